"""Images as a pinhole camera without a distorting lens would have taken them."""

from dataclasses import dataclass, field

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float64, UInt8, UInt16

RADIAL = {"plumb_bob": (4, 5), "rational_polynomial": (8, 12, 14)}
"""Model -> numbers of coefficients: k1 k2 p1 p2 [k3 [k4 k5 k6 [s1 s2 s3 s4 [tx ty]]]]
(Brown 1966; the rational form is OpenCV's)."""
MAX_PX = 1 << 14
MAX_COEFFICIENT = 1e6
EQUIDISTANT = "equidistant"
"""k1 k2 k3 k4 of a fisheye (Kannala and Brandt 2006, DOI 10.1109/TPAMI.2006.153)."""


@dataclass(frozen=True, slots=True, eq=False)
class Lens:
    """Pinhole ``K`` (3, 3) in pixels of images of ``size`` (width, height), and its distortion.

    Raises:
        ValueError: unusable K or size, an unknown model or a wrong number of coefficients.
    """

    K: Float64
    size: tuple[int, int]
    model: str = "plumb_bob"
    coefficients: Float64 = field(default_factory=lambda: np.zeros(5))

    def __post_init__(self) -> None:
        if not (self.K[0, 0] > 0 and self.K[1, 1] > 0):
            raise ValueError(f"K: focal lengths {self.K[0, 0]:g} and {self.K[1, 1]:g}")
        if not (min(self.size) >= 1 and max(self.size) <= MAX_PX):
            raise ValueError(f"size: {self.size[0]}x{self.size[1]}")
        if not (np.abs(self.K) <= 100 * MAX_PX).all():
            raise ValueError(f"K: {self.K.tolist()}")
        if not (np.abs(self.coefficients) <= MAX_COEFFICIENT).all():
            raise ValueError("coefficients of the distortion are not finite, or absurd")
        if not self.is_pinhole and len(self.coefficients) not in self._counts():
            wanted = " or ".join(map(str, self._counts()))
            raise ValueError(f"{self.model}: {len(self.coefficients)} coefficients, not {wanted}")

    @property
    def is_pinhole(self) -> bool:
        """Tell whether there is nothing to undo; an equidistant lens is one of its own."""
        return self.model != EQUIDISTANT and not self.coefficients.any()

    def is_like(self, other: "Lens") -> bool:
        """Tell whether both make the same images."""
        return (
            (self.size, self.model) == (other.size, other.model)
            and np.array_equal(self.K, other.K)
            and np.array_equal(self.coefficients, other.coefficients)
        )

    def _counts(self) -> tuple[int, ...]:
        counts = (4,) if self.model == EQUIDISTANT else RADIAL.get(self.model)
        if counts is None:
            known = ", ".join([*RADIAL, EQUIDISTANT])
            raise ValueError(f"unknown distortion model '{self.model}' (known: {known})")
        return counts


class Undistortion:
    """Moves pixels from where a lens put them to where a pinhole with the same K has them.

    Colour is interpolated; depth is taken from the nearest pixel, for the mean of two surfaces is
    none. What the lens did not see is black, or 0 = no measurement.
    """

    def __init__(self, lens: Lens) -> None:
        self._lens = lens
        self._maps: tuple[Array, Array] | None = None

    def rgb(self, rgb: UInt8) -> UInt8:
        """Return uint8 (H, W, 3) of the same size; ``ValueError`` for another size."""
        return np.asarray(self._moved(rgb, cv2.INTER_LINEAR), np.uint8)

    def depth_mm(self, depth_mm: UInt16) -> UInt16:
        """Return uint16 (H, W) of the same size; ``ValueError`` for another size."""
        return np.asarray(self._moved(depth_mm, cv2.INTER_NEAREST), np.uint16)

    def _moved(self, image: Array, how: int) -> Array:
        width, height = self._lens.size
        if image.shape[:2] != (height, width):
            got = f"{image.shape[1]}x{image.shape[0]}"
            raise ValueError(f"image is {got}, camera_info says {width}x{height}")
        if self._lens.is_pinhole:
            return image
        if self._maps is None:
            self._maps = _maps(self._lens)
        moved: Array = cv2.remap(image, *self._maps, how, borderMode=cv2.BORDER_CONSTANT)
        return moved


def _maps(lens: Lens) -> tuple[Array, Array]:
    """Return the column and the row, float32 (H, W), that each pixel of the pinhole comes from."""
    K, d, size = lens.K, lens.coefficients.astype(np.float64), lens.size
    if lens.model == EQUIDISTANT:
        x, y = cv2.fisheye.initUndistortRectifyMap(K, d, np.eye(3), K, size, cv2.CV_32FC1)
    else:
        x, y = cv2.initUndistortRectifyMap(K, d, np.eye(3), K, size, cv2.CV_32FC1)
    return x, y
