"""Instance AP rule by rule, slow and literal: what the fast evaluation is compared with.

Written from the published rules of the ScanNet benchmark (evaluate_semantic_instance.py), with
its structure kept: full boolean masks, one record per instance, growing lists, the first free
prediction takes the object, and the area of the curve by a convolution of the recalls.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass
class Prediction:
    """``mask`` bool (N,) over the points of its scene."""

    mask: np.ndarray
    label: int
    score: float


@dataclass
class Record:
    """An object or a prediction: ``partners`` are (the other record, shared points)."""

    points: int
    score: float = 0.0
    void: int = 0
    partners: list[tuple["Record", int]] = field(default_factory=list)


def records(predictions, codes, label, valid, min_region):
    """Return the predictions and the objects of one class in one scene, each knowing the other."""
    objects = {}
    for code in np.unique(codes):
        if code != 0 and code // 1000 == label:
            objects[int(code)] = Record(points=int((codes == code).sum()))
    void = ~np.isin(codes // 1000, valid)
    predicted = []
    for prediction in predictions:
        size = int(np.count_nonzero(prediction.mask))
        if prediction.label != label or size < min_region:
            continue
        record = Record(size, prediction.score, int(np.count_nonzero(void & prediction.mask)))
        for code, thing in objects.items():
            shared = int(np.count_nonzero((codes == code) & prediction.mask))
            if shared > 0:
                record.partners.append((thing, shared))
                thing.partners.append((record, shared))
        predicted.append(record)
    return predicted, list(objects.values())


def judge(predicted, objects, threshold, min_region):
    """Return truths, scores, missed objects of one class in one scene."""
    taken = set()
    truths, scores, missed = [], [], 0
    counted = [thing for thing in objects if thing.points >= min_region]
    for thing in counted:
        best, matched = -np.inf, False
        for prediction, shared in thing.partners:
            if id(prediction) in taken:
                continue
            if shared / (thing.points + prediction.points - shared) > threshold:
                if matched:
                    truths.append(0.0)
                    scores.append(min(best, prediction.score))
                    best = max(best, prediction.score)
                else:
                    matched, best = True, prediction.score
                    taken.add(id(prediction))
        if matched:
            truths.append(1.0)
            scores.append(best)
        else:
            missed += 1
    for prediction in predicted:
        if any(
            shared / (thing.points + prediction.points - shared) > threshold
            for thing, shared in prediction.partners
        ):
            continue
        ignored = prediction.void
        for thing, shared in prediction.partners:
            if thing.points < min_region:
                ignored += shared
        if ignored / prediction.points <= threshold:
            truths.append(0.0)
            scores.append(prediction.score)
    return truths, scores, missed


def area(truths, scores, missed):
    """Return the area under the precision-recall curve."""
    if not scores:
        return 0.0
    order = np.argsort(scores)
    scores, truths = np.array(scores)[order], np.array(truths)[order]
    below = np.append(np.cumsum(truths), 0.0)  # index -1: nothing lies below the first
    total = truths.sum()
    precision, recall = [], []
    for first in np.unique(scores, return_index=True)[1]:
        right = total - below[first - 1]
        wrong = len(scores) - first - right
        lost = below[first - 1] + missed
        precision.append(right / (right + wrong))
        recall.append(right / (right + lost))
    precision.append(1.0)
    recall.append(0.0)
    padded = np.concatenate([recall[:1], recall, [0.0]])
    return float(np.dot(precision, np.convolve(padded, [-0.5, 0.0, 0.5], "valid")))


def reference_ap(scenes, classes, thresholds, min_region):
    """Return AP (classes, thresholds) of ``scenes``: pairs of predictions and codes (N,)."""
    valid = np.array(sorted(classes))
    ap = np.full((len(classes), len(thresholds)), np.nan)
    for row, label in enumerate(classes):
        gathered = [records(p, codes, label, valid, min_region) for p, codes in scenes]
        has_objects = any(t.points >= min_region for _, things in gathered for t in things)
        has_predictions = any(predicted for predicted, _ in gathered)
        for column, threshold in enumerate(thresholds):
            if not has_objects:
                continue
            if not has_predictions:
                ap[row, column] = 0.0
                continue
            truths, scores, missed = [], [], 0
            for predicted, things in gathered:
                more_truths, more_scores, more_missed = judge(
                    predicted, things, threshold, min_region
                )
                truths += more_truths
                scores += more_scores
                missed += more_missed
            ap[row, column] = area(truths, scores, missed)
    return ap


def without_classes(scenes, label):
    """Return the scenes as MaskClustering's --no_class reads them."""
    return [
        (
            [Prediction(p.mask, label, p.score) for p in predictions],
            codes % 1000 + label * 1000,
        )
        for predictions, codes in scenes
    ]


def annotated_only(scenes, classes, label):
    """Return the scenes with one class for everything in the benchmark; the rest is void.

    Numbers are renewed, for two labels may have used the same.
    """
    agnostic = []
    for predictions, codes in scenes:
        renewed = np.zeros_like(codes)
        kept = [c for c in np.unique(codes) if c // 1000 in classes]
        for number, code in enumerate(kept):
            renewed[codes == code] = label * 1000 + number
        agnostic.append(([Prediction(p.mask, label, p.score) for p in predictions], renewed))
    return agnostic
