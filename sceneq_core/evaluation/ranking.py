"""Are the right ones ahead of the wrong ones?"""

from collections.abc import Collection, Sequence

from sceneq_core.arrays import Bool, Float64


def auroc(score: Float64, positive: Bool) -> float | None:
    """Return how probably a positive has a higher ``score`` (N,) than a negative; a tie is half.

    The area under the ROC curve as the statistic of Mann and Whitney. ``None`` when all are
    positive or all negative: there is nothing to tell apart.

    Raises:
        ValueError: arrays of different length.
    """
    if len(score) != len(positive):
        raise ValueError(f"positive: {len(positive)} values for {len(score)} scores")
    # Imported here: scipy.stats takes most of a second, and few commands rank.
    from scipy.stats import rankdata

    count = int(positive.sum())
    others = len(positive) - count
    if not count or not others:
        return None
    ahead = float(rankdata(score)[positive].sum()) - count * (count + 1) / 2
    return ahead / (count * others)


def hit_at(ranked: Sequence[int], targets: Collection[int], k: int) -> bool:
    """Return whether one of the ``k`` first of ``ranked`` is a target (Hit@k)."""
    return any(one in targets for one in ranked[:k])
