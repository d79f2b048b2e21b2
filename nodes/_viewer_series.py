"""Rates, losses and delays as time series of a Rerun recording."""

import re
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from typing import Any

RATES, LOST, DELAYS = "series/rates", "series/lost", "series/delays"
OUT = ".out"
NOT_COUNTED = {"health.out", "metric.out", "pose.dropped"}
"""Heartbeats are no work, and whoever reads poses wants the newest only."""
LOSS = re.compile(r".*\.(dropped|undecodable)|.*_(dropped|skipped|lost|bad|refused|unmatched)")
"""The names of counters that say that something did not arrive or could not be used."""
REMEMBERED = 512
STALE_S = 3.0
"""A node that has been silent for so long has no rate."""
LINE_WIDTH = 1.5
NOTHING = float("nan")

Metrics = Mapping[str, float]


class Flows:
    """What every node sends a second and has lost so far, from its heartbeats."""

    def __init__(self) -> None:
        self._before: dict[str, tuple[float, float]] = {}

    def take(self, node: str, metrics: Metrics) -> tuple[float | None, float]:
        """Return the rate, ``None`` at the first heartbeat of a process, and the losses."""
        uptime_s = float(metrics.get("uptime_s", 0.0))
        counted = {name: value for name, value in metrics.items() if name not in NOT_COUNTED}
        sent = sum(value for name, value in counted.items() if name.endswith(OUT))
        lost = sum(value for name, value in counted.items() if LOSS.fullmatch(name))
        before_s, before = self._before.get(node, (float("inf"), 0.0))
        self._before[node] = (uptime_s, sent)
        again = uptime_s > before_s
        return (sent - before) / (uptime_s - before_s) if again else None, float(lost)


class Delays:
    """How long after a keyframe what was made of it is there."""

    def __init__(self) -> None:
        self._seen_s: OrderedDict[int, float] = OrderedDict()

    def start(self, seq: int, now_s: float) -> None:
        """Note that keyframe ``seq`` is there."""
        self._seen_s[seq] = now_s
        if len(self._seen_s) > REMEMBERED:
            self._seen_s.popitem(last=False)

    def since(self, seq: int, now_s: float) -> float | None:
        """Return the milliseconds since keyframe ``seq``, ``None`` when it was not seen."""
        return 1000 * (now_s - self._seen_s[seq]) if seq in self._seen_s else None


class Lines:
    """The lines of one plot; all of them are logged together.

    Args:
        path: entity of the plot.
        stale_s: after so long without a value a line has a gap.
        known: lines that are there from the beginning.
    """

    def __init__(self, path: str, stale_s: float = float("inf"), known: Sequence[str] = ()) -> None:
        self._path = path
        self._stale_s = stale_s
        self._values = dict.fromkeys(known, (NOTHING, 0.0))
        self._named = 0

    def set(self, name: str, value: float | None, now_s: float) -> None:
        """Give a line its value; ``None`` = it has none now."""
        self._values[name] = (NOTHING if value is None else value, now_s)

    def log(self, recording: Any, now_s: float) -> None:
        """Log the present values, and the names when there is a new one."""
        import rerun as rr

        if not self._values:
            return
        if self._named != len(self._values):
            self._named = len(self._values)
            style = rr.SeriesLines(names=list(self._values), widths=[LINE_WIDTH] * self._named)
            recording.log(self._path, style, static=True)
        fresh = [
            value if now_s - set_s < self._stale_s else NOTHING
            for value, set_s in self._values.values()
        ]
        recording.log(self._path, rr.Scalars(fresh))
