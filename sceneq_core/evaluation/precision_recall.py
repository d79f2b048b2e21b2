"""The precision-recall curve and its area."""

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.evaluation.matching import Matching


def precision_recall(matching: Matching) -> tuple[Float64, Float64]:
    """Return precision and recall at every distinct score, the lowest score first.

    Predictions of equal score enter the curve together, so that their order does not matter. The
    last point of the curve is made up: precision 1 at recall 0.
    """
    order = np.argsort(matching.score, kind="stable")
    score, is_true = matching.score[order], matching.is_true[order]
    _, first = np.unique(score, return_index=True)
    kept = len(score) - first
    found = np.cumsum(is_true[::-1])[::-1][first] if len(first) else np.zeros(0)
    objects = int(is_true.sum()) + matching.missed
    precision = found / kept
    recall = found / objects if objects else np.zeros(len(first))
    return np.append(precision, 1.0), np.append(recall, 0.0)


def average_precision(matching: Matching) -> float:
    """Return the area under the curve by the trapezoidal rule, 0 when nothing was judged.

    The ScanNet script weights every precision with half the distance of its neighbours' recalls,
    which is the same sum.
    """
    precision, recall = precision_recall(matching)
    if len(precision) == 1:
        return 0.0
    return float(np.trapezoid(precision[::-1], recall[::-1]))
