"""A recording played in its own time."""

import time
from collections.abc import Callable, Iterator

from sceneq_core.ingest.source import RawFrame, Skipped, Waiting

Frames = Iterator[RawFrame | Skipped | Waiting]
Clock = Callable[[], float]
NS_PER_S = 1e9


def paced(frames: Frames, speed: float, clock: Clock = time.monotonic) -> Frames:
    """Yield ``frames`` when they are due, ``Waiting`` before: ``speed`` times as fast as they came.

    The schedule starts with the first frame, and anew where stamps go back. Who takes frames more
    slowly gets each of them all the same. A speed of 0 does not wait.
    """
    if speed <= 0:
        yield from frames
        return
    start_s = first_ns = last_ns = None
    for frame in frames:
        if isinstance(frame, RawFrame):
            if first_ns is None or start_s is None or last_ns is None or frame.stamp_ns < last_ns:
                start_s, first_ns = clock(), frame.stamp_ns
            last_ns = frame.stamp_ns
            while clock() - start_s < (frame.stamp_ns - first_ns) / NS_PER_S / speed:
                yield Waiting()
        yield frame
