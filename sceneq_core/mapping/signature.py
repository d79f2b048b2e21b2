"""What an instance looks like whatever its place: its size and its colours."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, Int64, UInt8
from sceneq_core.mapping.boxes import level_axes

_BINS = (8, 16, 16)
_LOW = np.array([0.0, -96.0, -96.0], np.float32)
_WIDTH = np.array([12.5, 12.0, 12.0], np.float32)
_BLURS = (3, 1, 1)
"""Bins of CIELAB L, a, b and how often counts are spread over the neighbours: lightness counts
less, because it changes with the place."""

_SIZE_DOUBT = np.array([0.4, 0.7, 0.4])
"""How far the logs of length, width and height are apart in two looks at one thing: its far side
is often not seen, so its width is known least."""

_COLOUR_POWER = 4
"""Histograms are sums over many voxels: a small lack of overlap says much."""

_MOST_VOXELS = 4096


@dataclass(frozen=True, slots=True)
class Signature:
    """``size_m`` (3,) length, width, height as spreads; ``colours`` float32 (8, 16, 16), sum 1."""

    size_m: Float64
    colours: Float32


def signature_of(points_world: Float32, rgb: UInt8, up_world: Float64) -> Signature:
    """Return the signature of voxels at ``points_world`` (N, 3), N > 0, with ``rgb`` (N, 3)."""
    step = 1 + len(points_world) // _MOST_VOXELS
    return Signature(
        size_m=_spreads(points_world[::step].astype(np.float64), up_world),
        colours=_histogram(rgb[::step]),
    )


def likeness(one: Signature, other: Signature) -> float:
    """Return how alike two signatures are, 0 to 1; 1 = the same.

    A power of the overlap of the colours (Bhattacharyya coefficient) times a Gaussian of the ratio
    of the sizes.
    """
    colours = float(np.sqrt(one.colours * other.colours).sum()) ** _COLOUR_POWER
    deviation = np.log(one.size_m / other.size_m) / _SIZE_DOUBT
    return colours * float(np.exp(-0.5 * (deviation**2).mean()))


def _spreads(points_world: Float64, up_world: Float64) -> Float64:
    """Return the edges of the box whose points would spread as these do: strays count little."""
    level = (points_world - points_world.mean(axis=0)) @ level_axes(up_world)
    footprint = level[:, :2].T @ level[:, :2] / len(level)
    variance = np.append(np.linalg.eigvalsh(footprint)[::-1], (level[:, 2] ** 2).mean())
    edges: Float64 = np.sqrt(12.0 * np.maximum(variance, 1e-6))
    return edges


def _histogram(rgb: UInt8) -> Float32:
    lab = cv2.cvtColor(rgb[None].astype(np.float32) / np.float32(255), cv2.COLOR_RGB2LAB)[0]
    index: Int64 = ((lab - _LOW) / _WIDTH).astype(np.int64)
    index = np.clip(index, 0, np.array(_BINS) - 1)
    flat = np.ravel_multi_index(tuple(index.T), _BINS)
    histogram = np.bincount(flat, minlength=int(np.prod(_BINS))).reshape(_BINS).astype(np.float32)
    return _blurred(histogram) / np.float32(len(rgb))


def _blurred(histogram: Float32) -> Float32:
    """Spread every count over the neighbouring bins: a shade less is still the same colour."""
    for axis, times in enumerate(_BLURS):
        for _ in range(times):
            below = np.take(histogram, [0, *range(_BINS[axis] - 1)], axis)
            above = np.take(histogram, [*range(1, _BINS[axis]), _BINS[axis] - 1], axis)
            histogram = (below + 2 * histogram + above) / np.float32(4)
    return histogram
