"""What is wrong with what a robot sends: said once, counted always, shown as long as it lasts."""

import logging
from collections import Counter
from collections.abc import Callable

log = logging.getLogger(__name__)

Count = Callable[[str], None]


class Troubles:
    """Troubles by kind, such as ``no_camera_info``.

    Each one is logged the 1st, 2nd, 4th, 8th, ... time, and counted as ``ros_<kind>``.
    """

    def __init__(self, count: Count | None = None) -> None:
        self._count = count
        self._lasting: dict[str, str] = {}
        self.counts: Counter[str] = Counter()

    def tally(self, kind: str) -> None:
        """Count something that happens without anything being wrong."""
        self.counts[kind] += 1
        if self._count is not None:
            self._count(f"ros_{kind}")

    def note(self, kind: str, text: str) -> None:
        """Count something lost, and say it."""
        self.tally(kind)
        times = self.counts[kind]
        if times & (times - 1) == 0:
            often = f" (no. {times})" if times > 1 else ""
            log.warning("%s: %s%s", kind, text, often)

    def lasts(self, kind: str, text: str) -> None:
        """Say it now, and in ``text`` until it is over."""
        self.note(kind, text)
        self._lasting[kind] = text

    def over(self, kind: str) -> None:
        """Say that a trouble is gone, if it was there."""
        if self._lasting.pop(kind, None) is not None:
            log.info("%s: over", kind)

    def is_lasting(self, kind: str) -> bool:
        """Tell whether a trouble is not over."""
        return kind in self._lasting

    @property
    def text(self) -> str:
        """All that lasts, in a line."""
        return "; ".join(f"{kind}: {text}" for kind, text in sorted(self._lasting.items()))
