"""Is a policy worth having? Accuracy at its cost, beside what needs no policy at all."""

from collections.abc import Sequence


def mixed_accuracy(cost: float, never: tuple[float, float], always: tuple[float, float]) -> float:
    """Return the accuracy of asking at random, as often as costs the same.

    ``never`` and ``always`` are (cost, accuracy); between them random choice is a straight line.
    A policy that is not above it does not choose, it only throttles.
    """
    low, high = never[0], always[0]
    share = 0.0 if high <= low else min(max((cost - low) / (high - low), 0.0), 1.0)
    return never[1] + share * (always[1] - never[1])


def best_accuracy(cost: float, gains: Sequence[int], never: float) -> float:
    """Return the accuracy of perfect foresight with ``cost`` calls a question, one call each.

    ``gains`` are +1, 0 or -1 for every question: what the reasoner makes of it; ``never`` is the
    accuracy without reasoning. No policy is above this.
    """
    if not gains:
        return never
    mended = sum(gain > 0 for gain in gains)
    return never + min(cost * len(gains), mended) / len(gains)
