"""The answering side of large replies: whole, or in pages for whoever asks with ``?page=0``.

A map of a house takes tens of megabytes. In one piece that would hold up whatever shares the link,
and be lost altogether with the link; in pages, other data goes in between, and a lost page is
asked for again. The pages of one whole belong together, however the state changes meanwhile.
"""

import hashlib
import threading
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

import zstandard

from sceneq_nodes._bus import Handler, QueryError, Reply, Request
from sceneq_schemas.codec import encode
from sceneq_schemas.page import MAX_PAGES, PAGE_ENCODING, Page

PAGE_BYTES = 256 * 1024
"""A tenth of a second at 20 Mbit/s."""
ZSTD_LEVEL = 1
MOST_WHOLES = 4
FORGOTTEN_S = 60.0
"""A whole that nobody has asked for so long is forgotten."""
NUMBER = "page"
NAME = "of"


@dataclass(slots=True)
class _Whole:
    name: str
    size: int
    digest: str
    encoding: str
    data: bytes
    used_s: float


def paged(handler: Handler, page_bytes: int = PAGE_BYTES) -> Handler:
    """Return ``handler`` for requests without ``page``, else one that answers with pages of it."""
    return Pages(handler, page_bytes).answer


class Pages:
    """Cuts the replies of ``handler``; remembers the last ``MOST_WHOLES``, so that they last."""

    def __init__(
        self,
        handler: Handler,
        page_bytes: int = PAGE_BYTES,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._handler = handler
        self._page_bytes = page_bytes
        self._clock = clock
        self._wholes: OrderedDict[str, _Whole] = OrderedDict()
        self._lock = threading.Lock()

    def answer(self, request: Request) -> Reply | None:
        """Return the reply, or the page that is asked for; page 0 without ``of`` begins anew.

        Raises:
            QueryError: ``bad_request``, or ``gone`` when the whole is forgotten.
        """
        if NUMBER not in request.parameters:
            return self._handler(request)
        number = _number(request.parameters[NUMBER])
        name = request.parameters.get(NAME, "")
        whole = self._known(name) if name else self._new(request)
        return None if whole is None else self._page(whole, number)

    def _new(self, request: Request) -> _Whole | None:
        reply = self._handler(request)
        if reply is None:
            return None
        data = zstandard.ZstdCompressor(level=ZSTD_LEVEL).compress(reply.payload)
        digest = hashlib.sha256(reply.payload).hexdigest()
        whole = _Whole(digest[:16], len(reply.payload), digest, reply.encoding, data, self._clock())
        if len(data) > self._page_bytes:
            self._remember(whole)
        return whole

    def _remember(self, whole: _Whole) -> None:
        with self._lock:
            self._forget_unused()
            self._wholes[whole.name] = whole
            while len(self._wholes) > MOST_WHOLES:
                self._wholes.popitem(last=False)

    def _known(self, name: str) -> _Whole:
        with self._lock:
            self._forget_unused()
            if name not in self._wholes:
                raise QueryError("gone", "that whole is forgotten", "begin again with ?page=0")
            self._wholes.move_to_end(name)
            self._wholes[name].used_s = self._clock()
            return self._wholes[name]

    def _forget_unused(self) -> None:
        oldest_s = self._clock() - FORGOTTEN_S
        for name in [name for name, whole in self._wholes.items() if whole.used_s < oldest_s]:
            del self._wholes[name]

    def _page(self, whole: _Whole, number: int) -> Reply:
        # A page is made larger where there would be more of them than readers accept.
        length = max(self._page_bytes, -(-len(whole.data) // MAX_PAGES))
        pages = -(-len(whole.data) // length)
        if number >= pages:
            raise QueryError("bad_request", f"page {number} of {pages}", "pages count from 0")
        data = whole.data[number * length : (number + 1) * length]
        page = Page(whole.name, number, pages, whole.size, whole.digest, whole.encoding, data)
        return Reply(encode(page), PAGE_ENCODING)


def _number(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 6):
        raise QueryError("bad_request", f"page: expected a number, got {text!r:.20}", "try ?page=0")
    return int(text)
