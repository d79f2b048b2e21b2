"""A fixed piece of work to hold every stage against: sorting, gathering and multiplying."""

import time
from functools import cache

import numpy as np

from sceneq_core.arrays import Float32, Int64
from sceneq_tools.bench.measurement import median, samples_ms

NAME = "fixed numpy work"
POINTS = 300_000
"""About the pixels of one image."""
SIDE = 256
SECONDS = 0.5


def fixed_work() -> float:
    """Do the work, the same everywhere; return something that depends on all of it."""
    points, order, matrix = _input()
    ordered = np.sort(points)[order]
    means = np.add.reduceat(ordered, np.arange(0, POINTS, 100))
    return float(means.sum() + (matrix @ matrix).trace())


def fixed_work_ms(seconds: float = SECONDS) -> float:
    """Return how much processor time the work takes here and now."""
    return median(samples_ms(fixed_work, seconds, clock=time.process_time))


@cache
def _input() -> tuple[Float32, Int64, Float32]:
    rng = np.random.default_rng(7)
    points = rng.random(POINTS, dtype=np.float32)
    return points, rng.permutation(POINTS), rng.random((SIDE, SIDE), dtype=np.float32)
