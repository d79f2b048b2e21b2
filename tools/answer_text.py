"""Answers in words and columns; every field may be missing, as in answers of other versions."""

from collections.abc import Mapping, Sequence
from typing import Any

ENCODER = "encoder"
Answer = Mapping[str, Any]
COLUMNS = ("id", "label", "p", "cosine", "centre m", "size m", "seen in")
NONE = "-"


def headline(answer: Answer) -> str:
    """Return ``found: 'red mug' (fast)`` and the like, below the sentence that says it."""
    question = answer.get("question")
    about = f": {question!r}" if question else ""
    route, reason = answer.get("route"), answer.get("reason")
    known = ", known" if answer.get("cached") else ""
    way = f" by the {route} route{known}" if route else ""
    first = f"{answer.get('status', 'answer')}{about}{way}" + (f" ({reason})" if reason else "")
    return "\n".join([*spoken(answer), first])


def spoken(answer: Answer) -> list[str]:
    """Return the sentence that answers the question, if there is one."""
    said = answer.get("said")
    return [said] if isinstance(said, str) and said else []


def rows(answer: Answer) -> list[tuple[str, ...]]:
    """Return one row of ``COLUMNS`` for each instance."""
    return [_row(instance) for instance in answer.get("instances", ())]


def footnotes(answer: Answer) -> list[str]:
    """Return confidence, cost and the map that was used, each on a line."""
    confidence, revision = answer.get("confidence") or {}, answer.get("map") or {}
    stages = (answer.get("cost") or {}).get("ms") or {}
    notes = {
        "confidence": _pairs(confidence),
        "map": _pairs(revision),
        "ms": _pairs({"total": answer.get("took_ms"), **stages}),
    }
    return [f"{name}: {text}" for name, text in notes.items() if text]


def as_text(answer: Answer) -> str:
    """Return an answer as aligned plain text."""
    table = [COLUMNS, *rows(answer)] if answer.get("instances") else []
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = [
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in table
    ]
    return "\n".join([headline(answer), *(f"  {line}" for line in lines), *footnotes(answer)])


def _row(instance: Answer) -> tuple[str, ...]:
    box = instance.get("box_oriented") or {}
    seen = [str(view.get("seq")) for view in instance.get("views") or ()]
    return (
        str(instance.get("id", NONE)),
        _label(instance),
        _number(instance.get("p")),
        _number(instance.get("cosine")),
        _numbers(instance.get("centre")),
        _numbers(box.get("size")),
        " ".join(seen) or NONE,
    )


def _label(instance: Answer) -> str:
    """Return the label; where it is not the encoder's guess, who it is from."""
    source = instance.get("label_source")
    origin = f" ({source})" if source not in (None, ENCODER) else ""
    return f"{instance.get('label', NONE)}{origin}"


def _numbers(values: Sequence[float] | None) -> str:
    return " ".join(f"{value:.2f}" for value in values) if values else NONE


def _number(value: Any) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return NONE if value is None else str(value)
    return f"{value:.0f}" if isinstance(value, int) or abs(value) >= 100 else f"{value:.3g}"


def _pairs(values: Mapping[str, Any]) -> str:
    return "  ".join(f"{k} {_number(v)}" for k, v in values.items() if v is not None)
