"""``sceneq schema``: the table of keys, and what an answer looks like."""

import json
from typing import Annotated, Any

import typer


def run(
    as_json: Annotated[bool, typer.Option("--json", help="As JSON, for programs.")] = False,
    answer: Annotated[bool, typer.Option("--answer", help="The JSON Schema of answers.")] = False,
) -> None:
    """Print what flows: keys, writers, message types, delivery, rates."""
    if answer:
        from sceneq_schemas.answer import ANSWER

        typer.echo(json.dumps(ANSWER, indent=2))
        return
    rows = [_row(topic) for topic in _topics()]
    if as_json:
        typer.echo(json.dumps(rows, indent=2))
        return
    from sceneq_tools.table import print_table

    print_table(
        ("key", "writer", "message", "delivery", "Hz", "limit"),
        [
            (
                row["key"],
                row["writer"],
                row["message"] or row["encoding"].partition(";")[0].partition("/")[2].upper(),
                row["delivery"],
                f"{row['rate_hz']:g}" if row["rate_hz"] else "",
                _size(row["max_bytes"]),
            )
            for row in rows
        ],
    )


def _topics() -> Any:
    from sceneq_schemas.topics import TOPICS

    return TOPICS


def _row(topic: Any) -> dict[str, Any]:
    return {
        "key": topic.pattern,
        "writer": topic.writer,
        "message": topic.message.__name__ if topic.message else None,
        "encoding": topic.encoding,
        "delivery": topic.delivery.name.lower(),
        "delivery_means": topic.delivery.value,
        "rate_hz": topic.rate_hz,
        "max_bytes": topic.max_bytes,
    }


def _size(count: int) -> str:
    for unit, name in ((1 << 20, "MiB"), (1 << 10, "KiB")):
        if count >= unit:
            return f"{count // unit} {name}"
    return f"{count} B" if count else ""
