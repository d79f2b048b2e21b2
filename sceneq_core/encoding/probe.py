"""A linear probe: names that a classifier never learned, read from its pooled feature.

G. Alain and Y. Bengio, "Understanding intermediate layers using linear classifier probes", 2016,
doi 10.48550/arXiv.1610.01644.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.joint import unit


@dataclass(frozen=True, slots=True, eq=False)
class Probe:
    """``names`` (H) of things; ``weights`` float32 (F, H) and ``bias`` (H,) of their logits."""

    names: tuple[str, ...]
    weights: Float32
    bias: Float32

    def __post_init__(self) -> None:
        count = len(self.names)
        if self.weights.ndim != 2 or self.weights.shape[1] != count or len(self.bias) != count:
            shapes = f"weights {self.weights.shape}, bias {self.bias.shape}"
            raise ValueError(f"probe: {count} names do not fit {shapes}")
        if not (np.isfinite(self.weights).all() and np.isfinite(self.bias).all()):
            raise ValueError("probe: weights or bias are not finite")

    def __len__(self) -> int:
        return len(self.names)

    def probabilities(self, feature: Float32) -> Float32:
        """Return how probable each name is, float32 (H,), of a pooled ``feature`` (F,)."""
        logits = unit(feature) @ self.weights + self.bias
        weight = np.exp(logits - logits.max(initial=0.0))
        return np.asarray(weight / weight.sum(), np.float32) if len(weight) else weight
