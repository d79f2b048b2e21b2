"""Random numbers that belong to a point, whatever else is in the room."""

import numpy as np

from sceneq_core.arrays import Float32, Int32

Words = np.ndarray[tuple[int, ...], np.dtype[np.uint64]]


def jitter(seed: int, thing_id: Int32, number: Int32, stream: int) -> Float32:
    """Return float32 (N,) in [0, 1): the same for the same four numbers (SplitMix64's mixer)."""
    start = np.full(1, (seed * 1009 + stream) * 0x9E3779B97F4A7C15 % (1 << 64), np.uint64)
    word = number.astype(np.uint64) + thing_id.astype(np.uint64) * np.uint64(1 << 32)
    word = _mixed(word + start)
    return (word >> np.uint64(40)).astype(np.float32) / np.float32(1 << 24)


def _mixed(word: Words) -> Words:
    word = (word ^ (word >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    word = (word ^ (word >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return word ^ (word >> np.uint64(31))
