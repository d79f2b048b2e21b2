"""Which items of a state changed when, so that a reader can be told what it missed."""

from collections.abc import Iterable


class Changes:
    """The number of the last delta that told of each item; nothing is known before ``begin``."""

    def __init__(self, begin: int = 0) -> None:
        self._begin = begin
        self._told: dict[int, int] = {}

    def note(self, seq: int, ids: Iterable[int]) -> None:
        """Remember that delta ``seq`` told of ``ids``, gone ones too."""
        for item in ids:
            self._told.pop(item, None)  # the last told stand at the end
            self._told[item] = seq

    def after(self, seq: int) -> list[int] | None:
        """Return, sorted, the ids told of beyond ``seq``; ``None`` when that is not known."""
        if seq < self._begin:
            return None
        ids = []
        for item, told in reversed(self._told.items()):
            if told <= seq:
                break
            ids.append(item)
        return sorted(ids)
