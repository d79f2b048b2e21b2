"""Queries: parameters in, a bounded pool in the middle, a reply or an error out."""

import json
import logging
import queue
import re
import threading
from collections.abc import Callable, Mapping
from urllib.parse import quote, unquote

from sceneq_nodes._bus import Handler, QueryError, Reply, Request
from sceneq_nodes._wire import json_bytes

log = logging.getLogger(__name__)

WORKERS = 8
SLOTS = 32
BUSY_RETRY_MS = 200
ERROR_ENCODING = "application/json;sceneq.error.v1"

_PERCENT = re.compile(r"%[0-9A-Fa-f]{2}")

Job = Callable[[], None]


class QueryPool:
    """Runs jobs on ``WORKERS`` threads and holds at most ``SLOTS``, running or waiting.

    The threads are daemons: a query that takes a minute does not keep the process alive.
    """

    def __init__(self, workers: int = WORKERS, slots: int = SLOTS) -> None:
        self._workers = workers
        self._free = threading.Semaphore(slots)
        self._jobs: queue.SimpleQueue[Job] = queue.SimpleQueue()
        self._start = threading.Lock()
        self._started = False

    def submit(self, job: Job) -> None:
        """Run ``job`` soon; raise ``QueryError`` ``busy`` when every slot is taken."""
        if not self._free.acquire(blocking=False):
            raise QueryError("busy", "too many queries wait", "try again", BUSY_RETRY_MS)
        self._ensure_started()
        self._jobs.put(job)

    def _ensure_started(self) -> None:
        with self._start:
            if not self._started:
                self._started = True
                for _ in range(self._workers):
                    threading.Thread(target=self._work, name="query", daemon=True).start()

    def _work(self) -> None:
        while True:
            job = self._jobs.get()
            try:
                job()
            except Exception:
                log.exception("a query could not be answered")
            finally:
                self._free.release()


def answer(handler: Handler, request: Request) -> Reply | QueryError | None:
    """Return what ``handler`` says; an exception it did not mean becomes ``internal``."""
    try:
        reply = handler(request)
    except QueryError as error:
        return error
    except Exception as error:
        log.exception("query on %s failed", request.key)
        return QueryError("internal", f"{type(error).__name__}: {error}", "see the node's log")
    limit = request.topic.max_bytes
    if reply is not None and len(reply.payload) > limit:
        return QueryError("too_large", f"the reply has {len(reply.payload)} bytes of {limit}")
    return reply


def error_bytes(error: QueryError) -> bytes:
    """Return the JSON that travels as ``reply_err``."""
    body: dict[str, object] = {"code": error.code, "message": error.message, "hint": error.hint}
    if error.retry_ms is not None:
        body["retry_ms"] = error.retry_ms
    return json_bytes(body)


def error_from_bytes(payload: bytes) -> QueryError:
    """Return the error in a ``reply_err``; zenoh's own are plain text such as ``Timeout``."""
    try:
        body = json.loads(payload)
        retry_ms = body.get("retry_ms")
        text = {name: str(body.get(name, "")) for name in ("message", "hint")}
        return QueryError(str(body["code"]), text["message"], text["hint"], retry_ms)
    except (ValueError, KeyError, AttributeError, RecursionError):
        message = payload[:200].decode(errors="replace")
        return QueryError("timeout" if message == "Timeout" else "unknown", message)


def parse_parameters(text: str) -> dict[str, str]:
    """Return the parameters of a selector.

    Zenoh separates them by ``;`` and decodes nothing. ``%XX`` is decoded, a lone ``%`` is left as
    it is, and of two with the same name the first counts, as in zenoh.
    """
    parameters: dict[str, str] = {}
    for part in filter(None, text.split(";")):
        name, _, value = part.partition("=")
        parameters.setdefault(_unquote(name), _unquote(value))
    return parameters


def format_parameters(parameters: Mapping[str, str]) -> str:
    """Return the text that ``parse_parameters`` turns back into ``parameters``."""
    return ";".join(f"{_quote(name)}={_quote(value)}" for name, value in parameters.items())


def _unquote(text: str) -> str:
    return unquote(text) if _PERCENT.search(text) else text


def _quote(text: str) -> str:
    return quote(text, safe=" !\"$&'()*+,-./:<>@[\\]^_`{}~?")
