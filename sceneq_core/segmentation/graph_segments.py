"""Colour segments by the pairwise region comparison of Felzenszwalb and Huttenlocher.

P. Felzenszwalb, D. Huttenlocher: Efficient Graph-Based Image Segmentation. IJCV 59(2), 2004,
doi:10.1023/B:VISI.0000022288.19776.77. Their merge predicate, applied in Boruvka rounds (every
region to its nearest neighbour at once) instead of one edge at a time, so that numpy carries it.
"""

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float32, Float64, Int32, UInt16

LEVELS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Colour differences (CIELAB) up to which edges are looked at, in turn: light edges have to merge
before heavy ones, or a region's internal difference no longer means what it does in the paper. Up
to the first, which is sensor noise and below what an eye tells apart, everything merges."""

_NEIGHBOURS = ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:]))
_PER_UNIT = 256
"""Differences are whole 256ths: finer than the camera's noise, and 16 bits sort in linear time."""
_NO_EDGE = 65535


def graph_segments(colour: Float32, domain: Int32, scale: float, min_pixels: int) -> Int32:
    """Return regions int32 (h, w), numbered from 1, that never cross a border of ``domain``.

    ``colour`` is float32 (h, w, 3) in units of one just noticeable difference; pixels with
    ``domain`` < 0 are in no region (0). ``scale`` (colour difference x pixels) is the paper's k: a
    region of n pixels tolerates k / n beyond its internal difference. Regions under ``min_pixels``
    join their most similar neighbour of the same domain.
    """
    patches, regions = _patches(colour, domain)
    for level in LEVELS[1:]:
        while regions.merge_round(scale, heaviest=level):
            pass
    while regions.merge_round(scale, min_pixels=min_pixels):
        pass
    segments: Int32 = regions.numbers()[patches]
    return segments


class _Regions:
    """A partition of patches under merging, with the edges that still join two regions.

    Edges are kept sorted by weight, so the first that names a region is its nearest. Of the edges
    between two regions only the lightest ever matters; to look for the others costs more than to
    carry them along.
    """

    def __init__(
        self, size: Float64, internal: Float32, low: Int32, high: Int32, weights: Float32
    ) -> None:
        self._size = size
        self._internal = internal
        self._low, self._high = low, high
        self._weights = weights
        self._renumberings: list[Array] = [np.arange(len(size), dtype=np.int32)]

    def numbers(self) -> Int32:
        """Return the region of every patch."""
        numbers: Int32 = self._renumberings[-1]
        for earlier in self._renumberings[-2::-1]:
            numbers = numbers[earlier]
        return numbers

    def merge_round(self, scale: float, heaviest: float = np.inf, min_pixels: int = 0) -> bool:
        """Join every region to its nearest neighbour where the predicate holds; False = done."""
        region, edge = self._nearest_edges(heaviest)
        neighbour = self._low[edge] + self._high[edge] - region
        if min_pixels:
            joins = np.minimum(self._size[region], self._size[neighbour]) < min_pixels
        else:
            tolerance = self._internal + scale / self._size
            joins = self._weights[edge] <= np.minimum(tolerance[region], tolerance[neighbour])
        if not joins.any():
            return False
        self._join(region[joins], neighbour[joins], self._weights[edge[joins]])
        return True

    def _nearest_edges(self, heaviest: float) -> tuple[Array, Array]:
        """Return the regions with an edge up to ``heaviest`` and the lightest edge of each."""
        count = int(np.searchsorted(self._weights, heaviest, side="right"))
        backwards = np.arange(count - 1, -1, -1, dtype=np.int32)
        nearest = np.full((2, len(self._size)), count, np.int32)
        for first, ends in zip(nearest, (self._low, self._high), strict=True):
            first[ends[:count][::-1]] = backwards  # the last assignment stays
        edge = np.minimum(*nearest)
        region = np.flatnonzero(edge < count).astype(np.int32)
        return region, edge[region]

    def _join(self, region: Array, neighbour: Array, weights: Float32) -> None:
        """Join each ``region`` to its ``neighbour`` and number the unions anew."""
        root = _roots(len(self._size), region, neighbour)
        is_root = root == np.arange(len(root))
        number = (np.cumsum(is_root, dtype=np.int32) - 1)[root]
        internal = self._internal[is_root]
        np.maximum.at(internal, number[region], np.maximum(self._internal[region], weights))
        self._internal = internal
        self._size = np.bincount(number, weights=self._size).astype(np.float64)
        self._renumberings.append(number)
        self._low, self._high = number[self._low], number[self._high]
        self._keep(np.flatnonzero(self._low != self._high))

    def _keep(self, edges: Array) -> None:
        self._low, self._high = self._low[edges], self._high[edges]
        self._weights = self._weights[edges]


def _roots(count: int, region: Array, neighbour: Array) -> Array:
    """Return one region of the union that each of ``count`` regions ends up in.

    Nearest neighbours form trees whose only cycle is a pair that are each other's nearest.
    """
    everyone = np.arange(count, dtype=np.int32)
    root = everyone.copy()
    root[region] = neighbour
    mutual = (root[root] == everyone) & (everyone < root)
    root[mutual] = everyone[mutual]
    while True:
        further = root[root]
        if np.array_equal(further, root):
            return root
        root = further


def _patches(colour: Float32, domain: Int32) -> tuple[Int32, _Regions]:
    """Return the patches of one colour up to the first level, (h, w), 0 = outside, as regions.

    Region 0 has no edges: it is the outside.
    """
    differences = _differences(colour, domain)
    patches = _connected(domain >= 0, *(d <= LEVELS[0] * _PER_UNIT for d in differences))
    low, high = (
        np.concatenate([patches[ends[i]].reshape(-1) for ends in _NEIGHBOURS]) for i in (0, 1)
    )
    steps = np.concatenate([d.reshape(-1) for d in differences])
    weights = steps.astype(np.float32) / np.float32(_PER_UNIT)
    size = np.maximum(np.bincount(patches.reshape(-1)), 1).astype(np.float64)
    internal = np.zeros(len(size), np.float32)
    alike = np.flatnonzero(weights <= LEVELS[0])
    np.maximum.at(internal, low[alike], weights[alike])
    crossing = np.flatnonzero((low != high) & (steps < _NO_EDGE))
    edges = crossing[np.argsort(steps[crossing], kind="stable")]
    return patches, _Regions(size, internal, low[edges], high[edges], weights[edges])


def _differences(colour: Float32, domain: Int32) -> list[UInt16]:
    """Return the colour difference to the right (h, w - 1) and downwards (h - 1, w)."""
    differences = []
    channels = cv2.split(colour)
    for near, far in _NEIGHBOURS:
        square = np.zeros(domain[near].shape, np.float32)
        for channel in channels:
            square += (channel[near] - channel[far]) ** 2
        steps = np.minimum(np.sqrt(square) * _PER_UNIT, _NO_EDGE - 1).astype(np.uint16)
        steps[(domain[near] != domain[far]) | (domain[near] < 0)] = _NO_EDGE
        differences.append(steps)
    return differences


def _connected(inside: Bool, across: Bool, down: Bool) -> Int32:
    """Return the components (h, w), 0 = outside, of pixels linked to the right and downwards.

    The links are drawn between the pixels of an image of twice the size, so that the labelling of
    binary images does the work.
    """
    drawn = np.zeros((2 * inside.shape[0] - 1, 2 * inside.shape[1] - 1), np.uint8)
    drawn[::2, ::2], drawn[::2, 1::2], drawn[1::2, ::2] = inside, across, down
    return np.ascontiguousarray(cv2.connectedComponents(drawn, connectivity=4)[1][::2, ::2])
