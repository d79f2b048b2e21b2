"""Which predictions found an object: the rules of the ScanNet benchmark.

1. An object counts when it has at least ``min_region`` points, a prediction too.
2. A prediction hits an object when their IoU is ABOVE the threshold, not when it is equal.
3. Objects are visited in their order. Of the predictions that hit one and that no earlier object
   has taken, the FIRST in the order of the predictions takes it, not the most confident; the
   object gets the highest of their scores as a true positive, and every other of these scores is
   a false positive. Those other predictions stay free for later objects. (Above IoU 0.5 a
   prediction cannot hit two objects, so the order only matters at 0.25.)
4. An object that nobody takes is missed: it lowers the recall at every score.
5. A prediction that hits no object, not even one too small to count, is a false positive, unless
   it lies on what cannot be judged: when the share of its points that are void or on an object too
   small to count is ABOVE the threshold it is ignored. Objects of other classes are not void.
6. A prediction that hits only objects too small to count is ignored.

Source: ScanNet benchmark, ``evaluate_semantic_instance.py``, which adapts that of CityScapes.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_core.evaluation.overlap import Overlap


@dataclass(frozen=True, slots=True, eq=False)
class Matching:
    """The judged predictions of one class at one threshold.

    Attributes:
        score: float64 (E,) confidence of every judged prediction.
        is_true: bool (E,) whether it found an object.
        missed: objects that nobody found.
    """

    score: Float64
    is_true: Bool
    missed: int


NOTHING = Matching(np.zeros(0), np.zeros(0, bool), 0)


def match(pairs: Overlap, threshold: float, min_region: int) -> Matching:
    """Judge the predictions of one class in one scene; all have ``min_region`` points or more."""
    counts = pairs.object_size >= min_region
    hit = pairs.iou > threshold
    found, doubled = _found(pairs, hit & counts[pairs.object])
    astray = _false(pairs, hit, ~counts[pairs.object], threshold)
    false = np.concatenate([doubled, pairs.score[astray]])
    return Matching(
        score=np.concatenate([found, false]),
        is_true=np.arange(len(found) + len(false)) < len(found),
        missed=int(counts.sum()) - len(found),
    )


def together(matchings: Iterable[Matching]) -> Matching:
    """Return the matchings of several scenes as one."""
    every = [NOTHING, *matchings]
    return Matching(
        score=np.concatenate([one.score for one in every]),
        is_true=np.concatenate([one.is_true for one in every]),
        missed=sum(one.missed for one in every),
    )


def _found(pairs: Overlap, hit: Bool) -> tuple[Float64, Float64]:
    """Return the scores of objects that were found, and of their duplicates (rule 3)."""
    found: list[float] = []
    doubled: list[float] = []
    taken: set[int] = set()
    for hitting in _by_object(pairs.object[hit], pairs.prediction[hit]):
        free = [prediction for prediction in hitting.tolist() if prediction not in taken]
        if not free:
            continue
        taken.add(free[0])
        *rest, best = sorted(pairs.score[free].tolist())
        found.append(best)
        doubled.extend(rest)
    return np.array(found, np.float64), np.array(doubled, np.float64)


def _by_object(objects: Int64, predictions: Int64) -> Iterator[Int64]:
    """Yield the predictions of every object; the pairs are sorted by object."""
    if len(objects):
        yield from np.split(predictions, np.flatnonzero(np.diff(objects)) + 1)


def _false(pairs: Overlap, hit: Bool, is_small: Bool, threshold: float) -> Bool:
    """Tell which predictions (P,) hit nothing and cannot be excused (rules 5 and 6)."""
    count = len(pairs.score)
    hits = np.bincount(pairs.prediction[hit], minlength=count)
    on_small = np.bincount(pairs.prediction[is_small], pairs.shared[is_small], count)
    unjudged = (pairs.void + on_small) / pairs.prediction_size
    false: Bool = (hits == 0) & (unjudged <= threshold)
    return false
