"""From a crop to what an image tower reads: size, crop or pad, scale."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from sceneq_core.arrays import Float32, UInt8
from sceneq_core.checks import need_at_least, need_positive, need_within
from sceneq_core.encoding.resample import Kernel, Window, resample

Fit = Literal["crop", "squash", "pad"]
Colour = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Preprocess:
    """How a tower was fed when it was trained.

    ``height_px`` and ``width_px`` of its input. ``fit``: ``crop`` resizes the short edge to
    ``edge_px`` (0 = to fill the input) and cuts the middle out (CLIP), ``squash`` ignores the
    aspect (SigLIP), ``pad`` fits the long edge and fills the rest with grey ``fill``. Pixels 0..1
    become (x - ``mean``) / ``std``.
    """

    height_px: int
    width_px: int
    mean: Colour
    std: Colour
    fit: Fit = "crop"
    kernel: Kernel = "bicubic"
    edge_px: int = 0
    fill: int = 0

    def __post_init__(self) -> None:
        need_at_least(self, 1, "height_px", "width_px")
        need_within(self, 0, 255, "fill")
        if self.edge_px and self.edge_px < max(self.height_px, self.width_px):
            raise ValueError(f"edge_px: {self.edge_px} does not fill {self.height_px} pixels")
        if not min(self.std) > 0:
            raise ValueError(f"std: must be positive, got {self.std}")

    def __call__(self, rgb: UInt8) -> Float32:
        """Return ``rgb`` uint8 (h, w, 3) as float32 (3, height_px, width_px)."""
        return scaled(self.fitted(rgb), self.mean, self.std)

    def fitted(self, rgb: UInt8) -> UInt8:
        """Return ``rgb`` at the size of the input, uint8 (height_px, width_px, 3)."""
        height, width = rgb.shape[:2]
        if self.fit == "squash":
            return resample(rgb, (self.height_px, self.width_px), self.kernel)
        if self.fit == "crop":
            size = self._filling(height, width)
            return resample(rgb, size, self.kernel, self._middle(size))
        return self._padded(rgb)

    def _filling(self, height: int, width: int) -> tuple[int, int]:
        """Return the size whose short edge is ``edge_px``."""
        edge = self.edge_px or max(self.height_px, self.width_px)
        if height < width:
            return edge, int(edge * width / height)
        return int(edge * height / width), edge

    def _middle(self, size: tuple[int, int]) -> Window:
        top, left = (size[0] - self.height_px) // 2, (size[1] - self.width_px) // 2
        return top, left, self.height_px, self.width_px

    def _padded(self, rgb: UInt8) -> UInt8:
        height, width = rgb.shape[:2]
        ratio = min(self.height_px / height, self.width_px / width)
        size = max(1, round(height * ratio)), max(1, round(width * ratio))
        whole = np.full((self.height_px, self.width_px, 3), self.fill, np.uint8)
        top, left = (self.height_px - size[0]) // 2, (self.width_px - size[1]) // 2
        whole[top : top + size[0], left : left + size[1]] = resample(rgb, size, self.kernel)
        return whole


def scaled(rgb: UInt8, mean: Colour, std: Colour) -> Float32:
    """Return ``rgb`` uint8 (h, w, 3) as (x / 255 - mean) / std, float32 (3, h, w)."""
    gain = 1.0 / (255.0 * np.asarray(std))
    shift = np.asarray(mean) / np.asarray(std)
    values = rgb.astype(np.float32) * gain.astype(np.float32) - shift.astype(np.float32)
    return np.ascontiguousarray(values.transpose(2, 0, 1))


@dataclass(frozen=True, slots=True)
class Patches:
    """A picture as a sequence: ``values`` float32 (N, p * p * 3), of which ``rows`` * ``columns``
    are patches, row by row, and the rest is zero.
    """

    values: Float32
    rows: int
    columns: int


@dataclass(frozen=True, slots=True)
class PatchPreprocess:
    """Towers that keep the aspect: at most ``patches`` squares of ``patch_px`` (NaFlex, SigLIP 2:
    M. Tschannen et al., 2025, doi 10.48550/arXiv.2502.14786).
    """

    patch_px: int
    patches: int
    mean: Colour
    std: Colour
    kernel: Kernel = "bilinear"

    def __post_init__(self) -> None:
        need_positive(self, "patch_px", "patches")

    def __call__(self, rgb: UInt8) -> Patches:
        """Return ``rgb`` uint8 (h, w, 3) as patches."""
        rows, columns = self._grid(rgb.shape[0], rgb.shape[1])
        p = self.patch_px
        fitted = scaled(resample(rgb, (rows * p, columns * p), self.kernel), self.mean, self.std)
        squares = fitted.reshape(3, rows, p, columns, p).transpose(1, 3, 2, 4, 0)
        values = np.zeros((self.patches, p * p * 3), np.float32)
        values[: rows * columns] = squares.reshape(rows * columns, -1)
        return Patches(values, rows, columns)

    def _grid(self, height: int, width: int) -> tuple[int, int]:
        """Return the largest grid of patches of about this aspect, by halving the interval."""
        low, high = 1e-6, 100.0
        while high - low >= 1e-5:
            scale = (low + high) / 2
            rows, columns = self._count(height * scale), self._count(width * scale)
            low, high = (scale, high) if rows * columns <= self.patches else (low, scale)
        return self._count(height * low), self._count(width * low)

    def _count(self, length_px: float) -> int:
        return max(1, int(np.ceil(length_px / self.patch_px)))
