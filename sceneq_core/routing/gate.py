"""Is the first guess good enough to answer at once, or should somebody think longer?"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.checks import need_within


@dataclass(frozen=True, slots=True)
class Confidence:
    """How sure a softmax is: what the gate looks at and every answer reports.

    ``p_max`` is the highest probability of a choice, ``margin`` its distance to the next, negative
    when "none of them" is likelier; ``entropy_norm`` the entropy of all, "none" included, divided
    by its maximum (0 = certain, 1 = uniform); ``temperature`` the T of softmax(s / T).
    ``p_null`` is the probability of "none of them"; 0 where nothing has calibrated it: then all
    this is said on the supposition that there is one.
    """

    p_max: float
    margin: float
    entropy_norm: float
    temperature: float
    p_null: float = 0.0

    @classmethod
    def of(cls, p: Float64, temperature: float, p_null: float = 0.0) -> "Confidence":
        """Measure probabilities ``p`` (C,) and ``p_null``, which add up to 1.

        No choices at all = no confidence.
        """
        if len(p) == 0:
            return cls(0.0, 0.0, 1.0, temperature, p_null)
        best = np.sort(p)[::-1]
        second = max(float(best[1]) if len(best) > 1 else 0.0, p_null)
        spread = entropy_norm(np.append(p, p_null) if p_null else p)
        return cls(float(best[0]), float(best[0]) - second, spread, temperature, p_null)


@dataclass(frozen=True, slots=True)
class GateParams:
    """Thresholds of the fast path.

    It is taken when p_max and margin are high enough and either the entropy is low or the
    margin is clear: a long tail of tiny probabilities must not hide a clear winner.
    """

    min_p: float = 0.50
    min_margin: float = 0.15
    max_entropy_norm: float = 0.35
    clear_margin: float = 0.20

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "min_p", "min_margin", "max_entropy_norm", "clear_margin")

    def passes(
        self,
        p_max: float | Float64,
        margin: float | Float64,
        entropy_norm: float | Float64,
    ) -> bool | Bool:
        """Return whether one guess passes, or which of many when the measures are arrays (N,)."""
        sure = (p_max >= self.min_p) & (margin >= self.min_margin)
        clear = (entropy_norm <= self.max_entropy_norm) | (margin >= self.clear_margin)
        return sure & clear


class Gate:
    """Decides between the fast path and the reasoner; monotone in all three measures."""

    def __init__(self, params: GateParams) -> None:
        self.params = params

    def accepts(self, confidence: Confidence) -> bool:
        """Return whether the first guess may be the answer."""
        measures = confidence.p_max, confidence.margin, confidence.entropy_norm
        return bool(self.params.passes(*measures))


def softmax(scores: Float64, temperature: float) -> Float64:
    """Return softmax(scores / T) over the last axis, float64.

    Raises:
        ValueError: the temperature is not positive.
    """
    if not temperature > 0:
        raise ValueError(f"temperature: {temperature} is not positive")
    return np.exp(log_softmax(np.asarray(scores, np.float64) / temperature))


def capped(p: Float64, ceiling: float) -> Float64:
    """Return a distribution (C,) mixed with the uniform one until no value exceeds ``ceiling``.

    A temperature fits confidence on average; a few scores far out still come out surer than the
    encoder has ever been right. The order stays; below the ceiling nothing changes.
    """
    top, chance = float(p.max(initial=0.0)), 1.0 / max(len(p), 1)
    if top <= ceiling:
        return p
    kept = max(ceiling - chance, 0.0) / (top - chance) if top > chance else 0.0
    return kept * p + (1.0 - kept) * chance


def log_softmax(logits: Float64) -> Float64:
    """Return the logarithm of softmax(logits) over the last axis; safe for large logits."""
    if logits.shape[-1] == 0:
        return logits
    shifted = logits - logits.max(axis=-1, keepdims=True)
    result: Float64 = shifted - np.log(np.exp(shifted).sum(axis=-1, keepdims=True))
    return result


def entropy_norm(p: Float64) -> float:
    """Return the entropy of ``p`` (C,) divided by log C; 0 for a single choice."""
    if len(p) < 2:
        return 0.0
    positive = p[p > 0]
    entropy = -float((positive * np.log(positive)).sum())
    return min(1.0, max(0.0, entropy / float(np.log(len(p)))))
