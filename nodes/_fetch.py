"""The asking side of large replies: one page a step, so that the node can do other things."""

import hashlib
from collections.abc import Mapping
from typing import Any

import zstandard

from sceneq_nodes._bus import Bus, QueryError, Reply
from sceneq_nodes._pages import NAME, NUMBER
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.codec import decode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.page import MAX_PAGE_BYTES, MAX_PAGES, PAGE_ENCODING, Page
from sceneq_schemas.topics import Topic

TIMEOUT_S = 2.0
TRIES = 5
"""So often in a row one page may get no answer; a partition longer than that begins anew."""


class Fetch:
    """One reply of a ``Delivery.BULK`` topic on its way.

    Attributes:
        done: nothing more will come.
        message: what came, ``None`` when nobody had an answer.
        received: bytes of pages so far, as they crossed the link.
    """

    def __init__(self, bus: Bus, topic: Topic, parameters: Mapping[str, str], **ids: str) -> None:
        self.done = False
        self.message: Any = None
        self.received = 0
        self._bus = bus
        self._topic = topic
        self._parameters = dict(parameters)
        self._ids: dict[str, Any] = ids
        self._first: Page | None = None
        self._pages: list[bytes] = []
        self._missed = 0

    def step(self) -> None:
        """Ask for the next page; one that goes unanswered is asked for again, ``TRIES`` times.

        Raises:
            QueryError: refused, ``gone`` or no answer any more.
            DecodeError: what came is not what the topic holds.
        """
        replies = self._ask()
        if self._first is None:
            self._begin(replies)
            return
        pages = [page for page in map(self._page, replies) if page.of == self._first.of]
        if pages:
            self._missed = 0
            self._take(pages[0])
            return
        self._missed += 1
        if self._missed >= TRIES:
            raise QueryError("timeout", f"{self._topic.name}: page {len(self._pages)} did not come")

    def _ask(self) -> list[Reply]:
        where = {NUMBER: str(len(self._pages))}
        if self._first is not None:
            where[NAME] = self._first.of
        asked = {**self._parameters, **where}
        return self._bus.ask(self._topic, parameters=asked, timeout_s=TIMEOUT_S, **self._ids)

    def _begin(self, replies: list[Reply]) -> None:
        """Take the newest of the replies that are whole, else the first page of one that is not."""
        first_pages = [self._page(reply) for reply in replies if reply.encoding == PAGE_ENCODING]
        wholes = [reply.payload for reply in replies if reply.encoding != PAGE_ENCODING]
        wholes += [self._joined(page, [page.data]) for page in first_pages if page.pages == 1]
        found = [from_bytes(self._topic, data) for data in wholes]
        self.received += sum(len(reply.payload) for reply in replies)
        if not found and first_pages:
            self._first = first_pages[0]
            self._take(self._first)
            return
        self.message = max(found, key=lambda message: (message.epoch, message.seq), default=None)
        self.done = True

    def _take(self, page: Page) -> None:
        first = self._first
        assert first is not None
        if page.page != len(self._pages) or page.pages != first.pages:
            raise DecodeError(f"page {page.page}/{page.pages} for {len(self._pages)}/{first.pages}")
        self._pages.append(page.data)
        self.received += len(page.data)
        if self.received > 2 * self._topic.max_bytes:
            raise DecodeError(f"{self._topic.name}: {self.received} bytes of pages")
        if len(self._pages) == first.pages:
            self.message = from_bytes(self._topic, self._joined(first, self._pages))
            self.done = True

    def _page(self, reply: Reply) -> Page:
        page = decode(Page, reply.payload, 2 * MAX_PAGE_BYTES)
        if not (1 <= page.pages <= MAX_PAGES and 0 <= page.page < page.pages):
            raise DecodeError(f"page {page.page} of {page.pages}")
        if not 0 <= page.size <= self._topic.max_bytes:
            raise DecodeError(f"{self._topic.name}: {page.size} bytes")
        return page

    def _joined(self, page: Page, pieces: list[bytes]) -> bytes:
        """Return the reply; its size is checked before memory is taken for it."""
        data = b"".join(pieces)
        try:
            promised = zstandard.get_frame_parameters(data).content_size
            if promised != page.size:
                raise DecodeError(f"page: zstd holds {promised} bytes, not {page.size}")
            whole = zstandard.ZstdDecompressor().decompress(data, allow_extra_data=False)
        except zstandard.ZstdError as error:
            raise DecodeError(f"page: not zstd: {error}") from error
        if hashlib.sha256(whole).hexdigest() != page.digest:
            raise DecodeError("page: the pages do not belong together")
        return whole
