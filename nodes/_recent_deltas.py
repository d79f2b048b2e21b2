"""The last deltas of the map, for a reader that missed some and must not skip any."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from heapq import merge
from operator import attrgetter

from sceneq_core.mapping.merged import merged
from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._convert import map_delta_from_message, map_delta_message
from sceneq_nodes._order import says_nothing
from sceneq_nodes._wire import to_bytes
from sceneq_schemas.map import MapDelta, MapDeltas
from sceneq_schemas.topics import MAP_JOURNAL

MAX_DELTAS = 256
MAX_VOXELS = 2_000_000
"""About 60 MB: whoever needs more than that is better served by the whole map."""
MAX_QUIET = 64
"""So many of those that only name a frame; they do not drive out what changed the map."""
FORGOTTEN = "forgotten"
"""The code of the error that tells a reader that only the whole map helps it."""


class RecentDeltas:
    """Deltas in the order of their numbers, of this run of the writer and the end of the last.

    Args:
        complete_after: every delta with content beyond this number is here.
        begin: the number before the first of this run.
        before: the deltas of the last run. What it may have told beyond them did not reach the
            disk.
    """

    def __init__(
        self, complete_after: int = 0, begin: int = 0, before: Iterable[MapDelta] = ()
    ) -> None:
        self._complete_after = complete_after
        self._deltas: deque[MapDelta] = deque()
        self._quiet: deque[MapDelta] = deque()
        self._voxels = 0
        self._begin, self._known = begin, complete_after
        for delta in before:
            self._remember(delta)
            self._known = delta.seq

    def add(self, delta: MapDelta) -> None:
        """Remember the newest; forget the oldest when there are too many."""
        self._remember(delta)

    def after(self, seq: int) -> tuple[MapDelta, ...] | None:
        """Return the deltas beyond ``seq``, ``None`` when one may be forgotten."""
        if seq < self._complete_after or self._known < seq < self._begin:
            return None
        return tuple(delta for delta in self if delta.seq > seq)

    def close(self) -> None:
        """Nothing to release."""

    def __iter__(self) -> Iterator[MapDelta]:
        return merge(self._deltas, self._quiet, key=attrgetter("seq"))

    def _remember(self, delta: MapDelta) -> list[MapDelta]:
        """Return those that were forgotten for it."""
        if says_nothing(delta):
            self._quiet.append(delta)
            return [self._quiet.popleft()] if len(self._quiet) > MAX_QUIET else []
        forgotten = []
        self._deltas.append(delta)
        self._voxels += len(delta.voxel_id)
        while len(self._deltas) > MAX_DELTAS or self._voxels > MAX_VOXELS:
            oldest = self._deltas.popleft()
            self._voxels -= len(oldest.voxel_id)
            self._complete_after = oldest.seq
            forgotten.append(oldest)
        return forgotten


def journal_reply(request: Request, epoch: int, seq: int, deltas: Sequence[MapDelta]) -> Reply:
    """Return ``deltas`` as they were told, or with ``?merged=1`` as one change."""
    if request.parameters.get("merged") == "1" and len(deltas) > 1:
        one = merged([map_delta_from_message(delta) for delta in deltas])
        deltas = [map_delta_message(one, epoch, deltas[-1].seq)]
    message = MapDeltas(epoch, seq, tuple(deltas))
    return Reply(to_bytes(MAP_JOURNAL, message), MAP_JOURNAL.encoding)


def wanted_deltas(request: Request) -> tuple[int, int]:
    """Return the ``epoch`` and ``after`` that a request names.

    Raises:
        QueryError: ``bad_request``, no whole numbers.
    """
    texts = [request.parameters.get(name, "") for name in ("epoch", "after")]
    if not all(text.isascii() and text.isdigit() and len(text) <= 18 for text in texts):
        raise QueryError(
            "bad_request", "expected whole numbers", "try ?epoch=1700000000000;after=7"
        )
    return int(texts[0]), int(texts[1])
