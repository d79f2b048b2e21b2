"""The colours of superpoints, and how much of them groups have in common."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Float32, Float64, Int32, Int64, UInt8
from sceneq_core.mapping.rows import with_rows

_WIDTH = 10.0
"""CIELAB units between two bins: what light and shade do to one material stays within a few."""
_LIGHTNESS_BINS, _TINT_BINS, _TINT_ZERO = 7, 24, 11
_BINS = _LIGHTNESS_BINS * _TINT_BINS * _TINT_BINS
_CORNERS = np.indices((2, 2, 2)).reshape(3, -1).T


@dataclass(frozen=True, slots=True)
class Colours:
    """What one keyframe says of distinct superpoints, parallel rows.

    ``superpoint_id`` int32 (C,); ``lab`` float32 (C, 3) the mean colour in CIELAB, lightness by
    half because shading changes it; ``voxels`` int64 (C,) how many of its voxels were seen.
    """

    superpoint_id: Int32
    lab: Float32
    voxels: Int64


NO_COLOURS = Colours(np.zeros(0, np.int32), np.zeros((0, 3), np.float32), np.zeros(0, np.int64))


def colours_in_view(superpoint_of_voxel: Int32, rgb: UInt8) -> Colours:
    """Return the colours of superpoints int32 (M,), -1 = none, of seen voxels uint8 (M, 3)."""
    superpoint = superpoint_of_voxel + 1
    voxels = np.bincount(superpoint, minlength=1)
    voxels[0] = 0
    seen = np.flatnonzero(voxels)
    sums = [np.bincount(superpoint, column, len(voxels))[seen] for column in rgb.T]
    mean = np.stack(sums, axis=1) / (255.0 * voxels[seen, None])
    lab = cv2.cvtColor(mean[None].astype(np.float32), cv2.COLOR_RGB2LAB)[0] if len(mean) else mean
    halved = np.asarray(lab, np.float32) * np.array((0.5, 1.0, 1.0), np.float32)
    return Colours((seen - 1).astype(np.int32), halved, voxels[seen])


class Palette:
    """The colour of every superpoint, as of the keyframe that showed most of it.

    A colour is spread over the bins round it, so that no border between bins parts equal things.
    """

    def __init__(self) -> None:
        self._voxels = np.zeros(0, np.int32)
        self._bin = np.zeros((0, len(_CORNERS)), np.int16)
        self._part = np.zeros((0, len(_CORNERS)), np.float32)

    def see(self, colours: Colours) -> None:
        """Take in what a keyframe shows."""
        count = int(colours.superpoint_id.max(initial=-1)) + 1
        self._voxels = with_rows(self._voxels, count, 0)
        self._bin, self._part = with_rows(self._bin, count, 0), with_rows(self._part, count, 0)
        more = colours.voxels >= self._voxels[colours.superpoint_id]
        row = colours.superpoint_id[more]
        self._voxels[row] = colours.voxels[more]
        self._bin[row], self._part[row] = _spread(colours.lab[more])

    def forget(self, superpoint_id: Int32) -> None:
        """Let these superpoints have no colour."""
        self._voxels[superpoint_id[superpoint_id < len(self._voxels)]] = 0

    def common(self, group: Int32, first: Array, second: Array) -> Float64:
        """Return the share of colour that pairs of groups have in common, float64 (P,), 0 to 1.

        ``group`` int32 (S,) of every superpoint, -1 = none. It is the intersection of the groups'
        histograms, 0 where no colour is known (Swain and Ballard, Color Indexing, IJCV 1991,
        doi:10.1007/BF00130487).
        """
        asked, place = np.unique(np.stack((first, second)), return_inverse=True)
        one, other = place.reshape(2, -1)
        histogram = self._histograms(group, asked)
        # Summed bin after bin: so bins that neither has cannot change how the sum is rounded.
        return np.minimum(histogram[one], histogram[other]).cumsum(axis=1)[:, -1]

    def _histograms(self, group: Int32, asked: Array) -> Float64:
        """Return float64 (A, B), each row with the sum 1, or 0 where no colour is known."""
        known = min(len(group), len(self._voxels))
        row = np.full(max(int(group.max(initial=0)), int(asked.max(initial=0))) + 2, -1, np.int64)
        row[asked] = np.arange(len(asked))
        row[-1] = -1
        of_superpoint = row[group[:known]]
        member = np.flatnonzero((of_superpoint >= 0) & (self._voxels[:known] > 0))
        table, columns = _dense(self._bin[member])
        cell = of_superpoint[member, None] * columns + table
        amount = self._part[member] * self._voxels[member, None]
        total = np.bincount(cell.reshape(-1), amount.reshape(-1), len(asked) * columns)
        sums = np.bincount(of_superpoint[member], amount.sum(axis=1), len(asked))
        return total.reshape(len(asked), columns) / np.maximum(sums, 1e-9)[:, None]


def _spread(lab: Float32) -> tuple[Array, Float32]:
    """Return the eight bins (C, 8) round colours (C, 3), and how much of each lies in them."""
    place = lab / np.float32(_WIDTH)
    low = np.floor(place).astype(np.int64)
    beyond = (place - low)[:, None]
    part = np.where(_CORNERS, beyond, 1 - beyond).prod(axis=2)
    corner = low[:, None] + _CORNERS + (0, _TINT_ZERO, _TINT_ZERO)
    corner = np.clip(corner, 0, (_LIGHTNESS_BINS - 1, _TINT_BINS - 1, _TINT_BINS - 1))
    bins = (corner[..., 0] * _TINT_BINS + corner[..., 1]) * _TINT_BINS + corner[..., 2]
    return bins.astype(np.int16), part.astype(np.float32)


def _dense(bins: Array) -> tuple[Array, int]:
    """Return the bins renumbered from 0 without gaps, and how many there are, at least 1."""
    used = np.zeros(_BINS, np.bool_)
    used[bins] = True
    number = np.cumsum(used) - 1
    return number[bins], max(1, int(used.sum()))
