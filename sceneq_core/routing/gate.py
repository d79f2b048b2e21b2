"""Is the first guess good enough to answer at once, or should somebody think longer?"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.checks import need_within


@dataclass(frozen=True, slots=True)
class Confidence:
    """How sure a softmax is: what the gate looks at and every answer reports.

    ``p_max`` is the highest probability, ``margin`` its distance to the second,
    ``entropy_norm`` the entropy divided by its maximum log C (0 = certain, 1 = uniform),
    ``temperature`` the T of softmax(s / T).
    """

    p_max: float
    margin: float
    entropy_norm: float
    temperature: float

    @classmethod
    def of(cls, p: Float64, temperature: float) -> "Confidence":
        """Measure a probability vector ``p`` (C,); no choices at all = no confidence."""
        if len(p) == 0:
            return cls(0.0, 0.0, 1.0, temperature)
        best = np.sort(p)[::-1]
        second = float(best[1]) if len(best) > 1 else 0.0
        return cls(float(best[0]), float(best[0]) - second, entropy_norm(p), temperature)


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
