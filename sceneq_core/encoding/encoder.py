"""The seam between the router and the model that compares images with words."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from sceneq_core.arrays import Bool, Float32, UInt8


@dataclass(frozen=True, slots=True)
class Crop:
    """A piece of an image: ``rgb`` uint8 (h, w, 3), ``mask`` bool (h, w) of the object in it."""

    rgb: UInt8
    mask: Bool


class Encoder(Protocol):
    """Two towers into one space; both are loaded on first use only.

    ``model_id`` matches ``[a-z0-9_-]+`` and changes whenever vectors stop being comparable.
    ``temperature`` is the T of softmax(s / T) fitted for this encoder. ``ceiling`` is the highest
    probability of a name that it has earned: the share of right ones among its surest; 1 = any.
    """

    model_id: str
    dim: int
    temperature: float
    ceiling: float

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return descriptors (N, dim), L2-normalised, and raw image features (N, F)."""

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised."""
