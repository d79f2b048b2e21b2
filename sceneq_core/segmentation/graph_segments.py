"""Colour segments by the pairwise region comparison of Felzenszwalb and Huttenlocher.

P. Felzenszwalb, D. Huttenlocher: Efficient Graph-Based Image Segmentation. IJCV 59(2), 2004,
doi:10.1023/B:VISI.0000022288.19776.77. Their merge predicate, applied in Boruvka rounds (every
region to its nearest neighbour at once) instead of one edge at a time, so that numpy carries it.
"""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from sceneq_core.arrays import Array, Bool, Float32, Int32

LEVELS = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)
"""Colour differences (CIELAB) up to which edges are looked at, in turn: light edges have to merge
before heavy ones, or a region's internal difference no longer means what it does in the paper. Up
to the first, which is sensor noise and below what an eye tells apart, everything merges."""


def graph_segments(colour: Float32, domain: Int32, scale: float, min_pixels: int) -> Int32:
    """Return regions int32 (h, w), numbered from 0, that never cross a border of ``domain``.

    ``colour`` is float32 (h, w, 3) in units of one just noticeable difference; pixels with
    ``domain`` < 0 stay alone. ``scale`` (colour difference x pixels) is the paper's k: a region of
    n pixels tolerates k / n beyond its internal difference. Regions under ``min_pixels`` join
    their most similar neighbour of the same domain.
    """
    edges, weights = _grid_edges(colour, domain)
    state = _Regions(domain.size, edges, weights)
    state.merge_all(LEVELS[0])
    for level in LEVELS[1:]:
        state.forget_parallel_edges()
        while state.merge_round(scale, heaviest=level):
            pass
    while state.merge_round(scale, min_pixels=min_pixels):
        pass
    return state.region.reshape(domain.shape)


class _Regions:
    """A partition of pixels under merging, with the edges that still join two regions."""

    def __init__(self, pixels: int, edges: Array, weights: Float32) -> None:
        self.region: Array = np.arange(pixels, dtype=np.int32)
        self._size: Array = np.ones(pixels, np.int64)
        self._internal: Float32 = np.zeros(pixels, np.float32)
        self._edges = edges
        self._weights = weights

    def merge_all(self, heaviest: float) -> None:
        """Join across every edge up to ``heaviest``."""
        count = int(np.searchsorted(self._weights, heaviest, side="right"))
        a, b = self._edges[:count].T
        self._join(a, b, self._weights[:count])

    def forget_parallel_edges(self) -> None:
        """Keep only the lightest edge between two regions; the others decide nothing."""
        low, high = np.sort(self._edges, axis=1).T.astype(np.int64)
        _, first = np.unique(low * len(self._size) + high, return_index=True)
        first.sort()
        self._edges, self._weights = self._edges[first], self._weights[first]

    def merge_round(self, scale: float, heaviest: float = np.inf, min_pixels: int = 0) -> bool:
        """Join every region to its nearest neighbour where the predicate holds; False = done."""
        nearest = self._nearest_edges(heaviest)
        a, b = self._edges[nearest].T
        if min_pixels:
            joins = np.minimum(self._size[a], self._size[b]) < min_pixels
        else:
            tolerance = self._internal + scale / self._size
            joins = self._weights[nearest] <= np.minimum(tolerance[a], tolerance[b])
        if not joins.any():
            return False
        self._join(a[joins], b[joins], self._weights[nearest][joins])
        return True

    def _nearest_edges(self, heaviest: float) -> Array:
        """Return the edge of least weight (then least index) of every region, each edge once.

        Edges are kept sorted by weight, so the first that names a region is its nearest.
        """
        count = np.searchsorted(self._weights, heaviest, side="right")
        ends = self._edges[:count].reshape(-1)
        first = np.full(len(self._size), len(ends), np.int64)
        first[ends[::-1]] = np.arange(len(ends) - 1, -1, -1)
        return np.unique(first[first < len(ends)] // 2)

    def _join(self, a: Array, b: Array, weights: Float32) -> None:
        n = len(self._size)
        count, group = connected_components(coo_array((np.ones(len(a)), (a, b)), shape=(n, n)))
        internal = np.zeros(count, np.float32)
        np.maximum.at(internal, group, self._internal)
        np.maximum.at(internal, group[a], weights)
        self._internal = internal
        self._size = np.bincount(group, weights=self._size, minlength=count).astype(np.int64)
        self.region = group[self.region]
        edges = group[self._edges]
        crossing = edges[:, 0] != edges[:, 1]
        self._edges, self._weights = edges[crossing], self._weights[crossing]


def _grid_edges(colour: Float32, domain: Int32) -> tuple[Array, Float32]:
    """Return the 4-neighbour edges (E, 2) inside one domain and their weights, level first."""
    index = np.arange(domain.size, dtype=np.int32).reshape(domain.shape)
    pairs, weights = [], []
    for near, far in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        inside = _same_domain(domain[near], domain[far])
        difference = colour[near] - colour[far]
        weights.append(np.sqrt(np.einsum("hwc,hwc->hw", difference, difference))[inside])
        pairs.append(np.stack([index[near][inside], index[far][inside]], axis=1))
    # Whole 256ths are finer than the camera's noise, and 16-bit integers sort in linear time.
    steps = np.minimum(np.concatenate(weights) * 256, 65535).astype(np.uint16)
    order = np.argsort(steps, kind="stable")
    return np.concatenate(pairs)[order], steps[order].astype(np.float32) / np.float32(256)


def _same_domain(a: Int32, b: Int32) -> Bool:
    same: Bool = (a == b) & (a >= 0)
    return same
