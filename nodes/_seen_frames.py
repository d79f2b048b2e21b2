"""Which keyframes were looked at: one that comes again is not looked at in another map."""

from collections import OrderedDict
from collections.abc import Iterable, Iterator

from sceneq_core.visits import visit_of

REMEMBERED = 65_536
"""As many as mapping knows: a recording that begins anew repeats them all."""


class SeenFrames:
    """Stamps of the last keyframes by number, in the order in which they were looked at.

    Attributes:
        added, removed: what is different since ``settle``.
    """

    def __init__(self) -> None:
        self._stamps: OrderedDict[int, int] = OrderedDict()
        self._newest: dict[int, int] = {}
        self.added: dict[int, int] = {}
        self.removed: set[int] = set()

    def __len__(self) -> int:
        return len(self._stamps)

    def __contains__(self, seq: object) -> bool:
        return seq in self._stamps

    def items(self) -> Iterator[tuple[int, int]]:
        """Yield number and stamp of each."""
        yield from self._stamps.items()

    def stamp_of(self, seq: int) -> int | None:
        """Return the stamp of a keyframe, ``None`` when it was not looked at."""
        return self._stamps.get(seq)

    def oldest(self, seq: int) -> int | None:
        """Return the first one of the visit that ``seq`` is of."""
        visit = visit_of(seq)
        return next((one for one in self._stamps if visit_of(one) == visit), None)

    def newest(self, seq: int) -> int:
        """Return the highest number of the visit that ``seq`` is of, -1 before the first."""
        return self._newest.get(visit_of(seq), -1)

    def add(self, seq: int, stamp_ns: int) -> None:
        """Note that a keyframe was looked at; forget the first when there are too many."""
        self._stamps[seq] = self.added[seq] = stamp_ns
        self.removed.discard(seq)
        self._newest[visit_of(seq)] = max(seq, self.newest(seq))
        if len(self._stamps) > REMEMBERED:
            self._remove(next(iter(self._stamps)))

    def clear(self) -> None:
        """Forget all: in another map nothing was looked at."""
        for seq in list(self._stamps):
            self._remove(seq)
        self._newest.clear()

    def resume(self, seen: Iterable[tuple[int, int]]) -> None:
        """Go on with what an earlier run saw."""
        for seq, stamp_ns in seen:
            self.add(seq, stamp_ns)
        self.settle()

    def settle(self) -> None:
        """Take what is here now for what is kept."""
        self.added, self.removed = {}, set()

    def _remove(self, seq: int) -> None:
        del self._stamps[seq]
        self.added.pop(seq, None)
        self.removed.add(seq)
