"""``sceneq ask``: put a question to a running graph."""

import json
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from sceneq_nodes._client import Client
    from sceneq_tools.scenes import Asked

FAST_TIMEOUT_S = 10.0
REASON_TIMEOUT_S = 60.0
Endpoint = Annotated[str, typer.Option("--connect", help="Router to ask.")]
DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"


class Mode(StrEnum):
    """How the answer is found."""

    fast = "fast"
    reason = "reason"


def run(
    question: Annotated[str, typer.Argument(help="What to look for, such as 'red mug'.")],
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="The answer as it came.")] = False,
    mode: Annotated[
        Mode | None, typer.Option(help="fast: descriptors only; reason: always the reasoner.")
    ] = None,
    k: Annotated[int, typer.Option("-k", min=1, help="How many instances to show.")] = 5,
    evidence: Annotated[
        Path | None, typer.Option(metavar="PNG", help="Write the views of the best instances.")
    ] = None,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Ask the map a question; exit code 0 = answered, 1 = no answer, 2 = wrong usage."""
    from sceneq_schemas.topics import QUERY_ASK, QUERY_INSTANCES
    from sceneq_tools import scenes
    from sceneq_tools.errors import UserError

    if not question.strip():
        raise UserError("an empty question (say what to look for, such as 'red mug')", 2)
    request: dict[str, Any] = {"q": question, "k": k}
    if mode is Mode.reason:
        request["mode"] = "reason"
    topic = QUERY_INSTANCES if mode is Mode.fast else QUERY_ASK
    timeout_s = FAST_TIMEOUT_S if mode is Mode.fast else REASON_TIMEOUT_S
    with scenes.connect(connect) as client:
        name = scenes.need_scene(client, scene)
        asked = scenes.ask(client, topic, name, request, timeout_s)
        if evidence is not None:
            show_evidence(client, asked, evidence)
    if as_json:
        typer.echo(json.dumps(asked.body, ensure_ascii=False, indent=2))
    else:
        _print(asked)


def show_evidence(client: "Client", asked: "Asked", path: Path) -> None:
    """Write the views of an answer's best instances as a picture and say so on stderr."""
    from sceneq_tools.evidence import write_evidence

    def picture(key: str) -> bytes | None:
        replies, _ = client.get(key, timeout_s=FAST_TIMEOUT_S)
        return replies[-1][1].payload if replies else None

    written = write_evidence(asked.body, picture, path)
    typer.echo(f"evidence: {path}" if written else "evidence: no instance to show", err=True)


def _print(asked: "Asked") -> None:
    from sceneq_tools.answer_text import COLUMNS, footnotes, headline, rows
    from sceneq_tools.table import print_table

    typer.echo(headline(asked.body))
    if found := rows(asked.body):
        print_table(COLUMNS, found)
    for note in footnotes(asked.body):
        typer.echo(note)
    typer.echo(f"scene {asked.scene}, {asked.round_trip_ms:.0f} ms from question to answer")
