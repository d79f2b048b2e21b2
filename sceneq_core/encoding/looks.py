"""How much a picture looks like something that the encoder was taught with.

The cosine of its feature with the nearest one of the lessons: near what was taught, names can be
trusted; far from it they are guesses (Y. Sun et al., "Out-of-distribution detection with deep
nearest neighbors", ICML 2022, DOI 10.48550/arXiv.2204.06507).
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.joint import unit

AXES = 192
"""Principal axes that are kept: with fewer, what was taught and what was not look more alike."""
FAMILIAR = 1.0
"""Of an encoder that does not tell: nothing looks strange to it."""


@runtime_checkable
class KnowsLooks(Protocol):
    """An encoder that knows what it was taught with."""

    def familiarity(self, feature: Float32) -> float:
        """Return how much a raw image feature (F,) is like one of the lessons, 1 = the same."""


def familiarity(encoder: object, feature: Float32) -> float:
    """Return how familiar a raw image feature (F,) is; ``FAMILIAR`` where nobody can tell."""
    return encoder.familiarity(feature) if isinstance(encoder, KnowsLooks) else FAMILIAR


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """What M things look like that were taught: ``things`` float32 (M, A), of length 1.

    On ``axes`` float32 (F, A) through the ``centre`` (F,) of all features.
    """

    centre: Float32
    axes: Float32
    things: Float32

    def __post_init__(self) -> None:
        if self.axes.ndim != 2 or len(self.axes) != len(self.centre):
            raise ValueError(f"axes: shape {self.axes.shape}, the centre has {self.centre.shape}")
        if not len(self.things) or self.things.shape[1:] != self.axes.shape[1:]:
            raise ValueError(f"things: shape {self.things.shape}, on {self.axes.shape[1]} axes")

    def familiarity(self, feature: Float32) -> float:
        """Return the cosine of a feature (F,) of length 1 with the nearest thing.

        Raises:
            ValueError: a feature of another length.
        """
        if feature.shape != self.centre.shape:
            raise ValueError(f"feature: shape {feature.shape}, expected {self.centre.shape}")
        seen = np.asarray((feature - self.centre) @ self.axes, np.float32)
        return float((self.things @ unit(seen)).max())


def learn_looks(features: Float32, axes: int = AXES) -> Looks:
    """Return the looks of things whose features are (M, F), each of length 1.

    Raises:
        ValueError: there are fewer than two things.
    """
    if len(features) < 2:
        raise ValueError(
            f"features: of {len(features)} things, two at least have to look different"
        )
    centre: Float32 = features.mean(axis=0)
    kept = _principal(features - centre, min(axes, len(features) - 1))
    on_axes = np.asarray((features - centre) @ kept, np.float32)
    return Looks(centre, kept, np.stack([unit(row) for row in on_axes]))


def _principal(centred: Float32, axes: int) -> Float32:
    """Return the first principal axes (F, A) of centred rows."""
    return np.ascontiguousarray(np.linalg.svd(centred, full_matrices=False)[2][:axes].T)
