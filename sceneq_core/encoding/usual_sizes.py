"""How large things of a name usually are, and how high they stand: what a map measures for sure.

Pictures of a sofa differ from one renderer or camera to the next, its length does not.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from sceneq_core.arrays import Float32, Float64

SHAPE, LENGTHS = 4, 3
"""Numbers of a shape: logarithms of three lengths in metres, longer and shorter side and height,
and metres from the floor to the underside."""

THINNEST_M = 0.03
"""What is flatter than the voxels of a map are fine is as flat as this."""
TYPICAL_SPREAD = np.array([0.25, 0.25, 0.25, 0.15])
"""Standard deviations within a name of which nothing is known; they count as ``PRIOR_COUNT`` things
that were measured."""
PRIOR_COUNT = 3
WIDENED = 1.4
"""The spreads of few models, times this: other houses have other things, and maps see parts."""
OUTLIERS, OUTLIER_SPREAD = 0.1, 3.0
"""So many things of a name are so much more different from the others."""
SMALLER = 0.5
"""What is shorter, narrower or lower than usual counts as this much as far from it: a map often has
seen a part only, but has seldom seen more of a sofa than there is."""
MOST = 2.0
"""A size alone makes a name at most exp(2) = 7 times as probable, or as improbable."""


@runtime_checkable
class KnowsSizes(Protocol):
    """An encoder whose descriptors can take account of the size of the thing."""

    def sized(self, descriptor: Float32, shape: Float64) -> Float32:
        """Return the descriptor (D,) of a thing that has this ``shape`` (4,), length 1."""


def sized(encoder: object, descriptor: Float32, shape: Float64) -> Float32:
    """Return the descriptor given the shape; as it was where the encoder knows no sizes."""
    return encoder.sized(descriptor, shape) if isinstance(encoder, KnowsSizes) else descriptor


def shape_of(sides_m: Sequence[float], height_m: float, underside_m: float) -> Float64:
    """Return the shape (4,) of a thing with two horizontal ``sides_m``, above the floor."""
    longer, shorter = max(sides_m), min(sides_m)
    lengths = np.maximum([longer, shorter, height_m], THINNEST_M)
    return np.append(np.log(lengths), underside_m)


@dataclass(frozen=True, slots=True, eq=False)
class UsualSizes:
    """``mean`` and ``spread`` float64 (H, 4) of the shapes of H names; infinite: never measured."""

    mean: Float64
    spread: Float64

    def __post_init__(self) -> None:
        if self.mean.shape != self.spread.shape or self.mean.shape[1:] != (SHAPE,):
            raise ValueError(f"sizes: mean {self.mean.shape}, spread {self.spread.shape}")
        if not (np.isfinite(self.mean).all() and (self.spread > 0).all()):
            raise ValueError("sizes: a mean is not finite or a spread not positive")

    def evidence(self, shape: Float64) -> Float64:
        """Return log p(shape | name) - log p(shape) float64 (H,), within +-``MOST``.

        p(shape) is the mean over the names; a name that was never measured gets 0.
        """
        known = np.isfinite(self.spread).all(axis=1)
        evidence = np.zeros(len(self.mean))
        if known.any():
            spread = self.spread[known] * WIDENED
            off = (shape - self.mean[known]) / spread
            off[:, :LENGTHS] *= np.where(off[:, :LENGTHS] < 0, SMALLER, 1.0)
            away = (off**2).sum(axis=1)
            near = np.log(1 - OUTLIERS) - away / 2
            far = np.log(OUTLIERS / OUTLIER_SPREAD**SHAPE) - away / (2 * OUTLIER_SPREAD**2)
            log_p = np.logaddexp(near, far) - np.log(spread).sum(axis=1)
            common = np.logaddexp.reduce(log_p) - np.log(known.sum())
            evidence[known] = np.clip(log_p - common, -MOST, MOST)
        return evidence


def learn_sizes(names: Sequence[str], examples: Sequence[tuple[str, Float64]]) -> UsualSizes:
    """Return the usual sizes of ``names`` from (name, shape (4,)) of things that were measured.

    Equal shapes count once: a model that is seen often is still one.
    """
    mean = np.zeros((len(names), SHAPE))
    spread = np.full((len(names), SHAPE), np.inf)
    for row, name in enumerate(names):
        shapes = np.array([shape for one, shape in examples if one == name])
        if len(shapes):
            shapes = np.unique(np.round(shapes, 2), axis=0)
            mean[row] = shapes.mean(axis=0)
            squares = len(shapes) * shapes.var(axis=0) + PRIOR_COUNT * TYPICAL_SPREAD**2
            spread[row] = np.sqrt(squares / (len(shapes) + PRIOR_COUNT))
    return UsualSizes(mean, spread)
