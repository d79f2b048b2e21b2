"""The log of a process: lines for people, or one JSON object a line for programs.

What a record is about, the seq of the message or the id of the question being worked on, is set by
the runtime round each of them and added to whatever is logged meanwhile.
"""

import json
import logging
import os
import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from datetime import UTC, datetime
from typing import Any

VARIABLE = "SCENEQ_LOG"
TEXT, JSON = "text", "json"
FORMS = (TEXT, JSON)
ID_BYTES = 4
MAX_MESSAGE = 4_000
"""Characters; a message that quotes what came from a stranger is cut there."""

_QUERY_ID = re.compile(rb"[0-9a-f]{8,32}")
_seq: ContextVar[int | None] = ContextVar("seq", default=None)
_query: ContextVar[str] = ContextVar("query", default="")


@contextmanager
def about_message(message: Any) -> Iterator[None]:
    """Say of which message, by its ``seq``, the records of this block are."""
    token = _seq.set(getattr(message, "seq", None))
    try:
        yield
    finally:
        _seq.reset(token)


@contextmanager
def about_query(attachment: bytes | None) -> Iterator[None]:
    """Say of which question the records of this block are: the asker's id for it, or a new one."""
    given = attachment is not None and _QUERY_ID.fullmatch(attachment)
    token = _query.set(given[0].decode() if given else os.urandom(ID_BYTES).hex())
    try:
        yield
    finally:
        _query.reset(token)


def query_attachment() -> bytes | None:
    """Return what tells the node that is asked which question this is part of."""
    return _query.get().encode() or None


def set_up_logs(node: str, scene: str, environment: Mapping[str, str] = os.environ) -> None:
    """Log to stderr in the form that ``SCENEQ_LOG`` says, by default as text.

    Raises:
        ValueError: a form that is not known.
    """
    form = environment.get(VARIABLE, TEXT) or TEXT
    if form not in FORMS:
        raise ValueError(f"{VARIABLE}: {form!r}, known: {', '.join(FORMS)}")
    handler = logging.StreamHandler(sys.stderr)
    handler.setFormatter(JsonLines(node, scene) if form == JSON else TextLines(node))
    logging.basicConfig(level=logging.INFO, handlers=[handler], force=True)


class TextLines(logging.Formatter):
    """``time LEVEL node: message``."""

    def __init__(self, node: str) -> None:
        super().__init__(f"%(asctime)s %(levelname)s {node}: %(message)s")


class JsonLines(logging.Formatter):
    """One object a line, whatever the message holds; fields that do not apply are left out."""

    def __init__(self, node: str, scene: str) -> None:
        super().__init__()
        self._who = {"node": node, "scene": scene}

    def format(self, record: logging.LogRecord) -> str:
        """Return the line."""
        at = datetime.fromtimestamp(record.created, UTC).isoformat(timespec="milliseconds")
        told = {"time": at, "level": record.levelname, **self._who, **_scope()}
        told |= {"logger": record.name, "message": record.getMessage()[:MAX_MESSAGE]}
        if record.exc_info:
            told["error"] = self.formatException(record.exc_info)
        return json.dumps(told)


def _scope() -> dict[str, Any]:
    scope = {"seq": _seq.get(), "query": _query.get()}
    return {name: value for name, value in scope.items() if value not in (None, "")}
