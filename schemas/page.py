"""A reply that is too large to be sent at once, in pages."""

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True, slots=True)
class Page:
    """One of the ``pages`` of the zstd frame that holds a reply, numbered from 0.

    ``of`` names the whole, for as long as the one who answers remembers it. ``size`` is how many
    bytes the reply has once all pages are together and decompressed, ``digest`` their sha256 in
    hex, ``encoding`` what they would have been sent as.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.page.v1"
    of: str
    page: int
    pages: int
    size: int
    digest: str
    encoding: str
    data: bytes


PAGE_ENCODING = f"application/msgpack;{Page.SCHEMA}"
MAX_PAGE_BYTES = 1024 * 1024
MAX_PAGES = 1024
"""256 MiB, the largest message there is, in pages of 256 KiB."""
