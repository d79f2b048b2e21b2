"""How well attributes fit each instance that are measured rather than recognised."""

from collections.abc import Sequence

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.routing.gate import log_softmax
from sceneq_core.routing.order_words import SIZE_WORDS
from sceneq_core.routing.scene import SceneSnapshot

SMALLEST_M = 0.01
LEAST_SPREAD = 0.25
"""Log units: things whose sizes differ by less than a quarter are no large and small ones."""


def log_excluded(log_p: Float64, rows: Sequence[int]) -> Float64:
    """Return log p (N,) that an instance has none of the colours ``rows`` of ``log_p`` (N, 11)."""
    p = np.exp(log_p[:, list(rows)]).sum(axis=1)
    rest: Float64 = np.log(np.maximum(1.0 - p, 1e-6))
    return rest


def log_size(snapshot: SceneSnapshot, size_words: Sequence[str], log_fit: Float64) -> Float64:
    """Return log p (N,) that the sizes fit: measured beside the things that may be meant.

    ``log_fit`` (N,) says which: a small cupboard is larger than a large cup. A middling one fits
    by one half.
    """
    weight = np.exp(log_softmax(log_fit))
    total = np.zeros(len(log_fit))
    extents = _extents(snapshot)
    for word in size_words:
        measure, direction = SIZE_WORDS[word]
        value = extents[measure]
        mean = float(weight @ value)
        spread = max(float(np.sqrt(weight @ (value - mean) ** 2)), LEAST_SPREAD)
        total -= np.log1p(np.exp(-2.0 * direction * (value - mean) / spread))
    return total


def _extents(snapshot: SceneSnapshot) -> dict[str, Float64]:
    """Return the logarithms of volume, height and the longest level edge (N,) of all boxes."""
    axes = np.stack([one.geometry.T_world_box[:3, :3] for one in snapshot.instances])
    size = np.stack([one.geometry.box_size_m for one in snapshot.instances])
    height = (np.abs(axes.transpose(0, 2, 1) @ snapshot.up_world) * size).sum(axis=1)
    upright = np.abs(axes.transpose(0, 2, 1) @ snapshot.up_world)
    length = np.where(upright > np.sqrt(0.5), 0.0, size).max(axis=1)
    volume = np.log(np.maximum(size, SMALLEST_M)).sum(axis=1)
    return {
        "volume": volume,
        "height": np.log(np.maximum(height, SMALLEST_M)),
        "length": np.log(np.maximum(length, SMALLEST_M)),
    }
