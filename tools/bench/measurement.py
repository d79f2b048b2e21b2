"""What a bench measures, and how."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

LEAST_SAMPLES = 5
FASTER_IS_MORE = "/s"
"""Units that end so are rates; of all others less is better."""


@dataclass(frozen=True, slots=True)
class Options:
    """``source`` a folder of frames, None = none; ``graph`` file, None = as for ``sceneq up``.

    ``seconds`` each sampling may take; ``frames`` of the source or of a room that are looked at,
    None = the bench's own choice; ``quiet``: show no progress.
    """

    source: Path | None = None
    graph: Path | None = None
    seconds: float = 1.0
    frames: int | None = None
    quiet: bool = False

    def __post_init__(self) -> None:
        if self.seconds <= 0:
            raise ValueError(f"seconds: must be positive, got {self.seconds}")
        if self.frames is not None and self.frames < 1:
            raise ValueError(f"frames: must be at least 1, got {self.frames}")


@dataclass(frozen=True, slots=True)
class Measurement:
    """A ``value`` in ``unit`` beside the ``reference``, in the same unit, that ``beside`` names.

    ``series`` is how it came about, in the same unit, where it grew with the recording.
    """

    name: str
    value: float
    unit: str
    beside: str = ""
    reference: float | None = None
    series: tuple[float, ...] = ()

    @property
    def ratio(self) -> float | None:
        """Return value / reference: what compares between machines."""
        return None if self.reference is None else self.value / self.reference

    @property
    def more_is_better(self) -> bool:
        """Tell which way is up."""
        return self.unit.endswith(FASTER_IS_MORE)


def samples_ms(
    work: Callable[[], object],
    seconds: float,
    warm_ups: int = 1,
    least: int = LEAST_SAMPLES,
    clock: Callable[[], float] = time.perf_counter,
) -> list[float]:
    """Return how long ``work`` took each time within ``seconds``, ``least`` times at least."""
    for _ in range(warm_ups):
        work()
    taken_ms: list[float] = []
    end_s = time.perf_counter() + seconds
    while len(taken_ms) < least or time.perf_counter() < end_s:
        start_s = clock()
        work()
        taken_ms.append(1000 * (clock() - start_s))
    return taken_ms


def in_turns_ms(
    works: Sequence[Callable[[], object]],
    seconds: float,
    warm_ups: int = 1,
    least: int = LEAST_SAMPLES,
) -> list[list[float]]:
    """Return how long each work took, all within ``seconds``, one after the other, again and again.

    What others do on the machine meanwhile slows a work and its reference alike.
    """
    taken_ms: list[list[float]] = [[] for _ in works]
    for work in works:
        for _ in range(warm_ups):
            work()
    end_s = time.perf_counter() + seconds
    while len(taken_ms[0]) < least or time.perf_counter() < end_s:
        for work, taken in zip(works, taken_ms, strict=True):
            start_s = time.perf_counter()
            work()
            taken.append(1000 * (time.perf_counter() - start_s))
    return taken_ms


def median(samples: list[float]) -> float:
    """Return the median, which a disturbed sample does not move."""
    return float(np.median(samples))


def p99(samples: list[float]) -> float:
    """Return what one in a hundred exceeds."""
    return float(np.percentile(samples, 99))


def latency(
    name: str, taken_ms: list[float], beside: str, reference_ms: list[float]
) -> list[Measurement]:
    """Return median and tail of a latency beside those of its reference."""
    return [
        Measurement(f"{name} p50", median(taken_ms), "ms", beside, median(reference_ms)),
        Measurement(f"{name} p99", p99(taken_ms), "ms", beside, p99(reference_ms)),
    ]
