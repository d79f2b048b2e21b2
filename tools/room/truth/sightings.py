"""In which frames which things were seen, and how well."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Array, Int64, UInt16
from sceneq_core.checks import need_positive


@dataclass(frozen=True, slots=True)
class SeenParams:
    """When a thing counts as seen.

    Attributes:
        well_share: of the image, in one frame; at 640x480 this is 400 pixels, a cup 3 m away.
        well_s: it was seen so well for so long in all, seconds.
        well_frames: and in no fewer frames.
    """

    well_share: float = 1.3e-3
    well_s: float = 0.8
    well_frames: int = 3

    def __post_init__(self) -> None:
        need_positive(self, *self.__dataclass_fields__)


@dataclass(frozen=True, slots=True, eq=False)
class Sightings:
    """``pixels`` int64 (frames, ids): how many pixels each id has in each frame."""

    pixels: Int64
    rate_hz: float
    image_pixels: int

    def frames(self, thing_id: int) -> int:
        """Return the number of frames that show any of a thing."""
        return int((self._of(thing_id) > 0).sum())

    def total(self, thing_id: int) -> int:
        """Return all pixels of a thing in all frames."""
        return int(self._of(thing_id).sum())

    def most(self, thing_id: int) -> int:
        """Return the pixels of a thing in its best frame."""
        return int(self._of(thing_id).max(initial=0))

    def well(self, thing_id: int, since: int, params: SeenParams) -> bool:
        """Tell whether a thing was seen well from frame ``since`` on."""
        least = params.well_share * self.image_pixels
        enough = max(params.well_frames, round(params.well_s * self.rate_hz))
        return int((self._of(thing_id)[since:] >= least).sum()) >= enough

    def until(self, last: int) -> "Sightings":
        """Return the sightings up to and with frame ``last``."""
        return Sightings(self.pixels[: last + 1], self.rate_hz, self.image_pixels)

    def _of(self, thing_id: int) -> Array:
        if thing_id >= self.pixels.shape[1]:
            return np.zeros(len(self.pixels), np.int64)
        return self.pixels[:, thing_id]


def sightings(rows: list[Int64], rate_hz: float, image_pixels: int) -> Sightings:
    """Put together the ``count_pixels`` of every frame, in order."""
    width = max(len(row) for row in rows)
    pixels = np.stack([np.pad(row, (0, width - len(row))) for row in rows])
    return Sightings(pixels, rate_hz, image_pixels)


def count_pixels(instance_id: UInt16) -> Int64:
    """Return how many pixels each id has in an instance image; index 0 is nothing."""
    return np.bincount(instance_id.ravel())
