"""Depth images compressed with RVL, as RTAB-Map and ROS' compressedDepth store them.

The image is runs: how many pixels are 0, how many are not, then the difference of each of these to
the one before it. A number is written in groups of three bits, the lowest first, each in four bits
whose highest says that more follow; eight of those make a little-endian 32-bit word, the first in
its highest bits.

Source: Wilson, "Fast Lossless Depth Image Compression", ISS 2017, DOI 10.1145/3132272.3134144.
"""

import numpy as np

from sceneq_core.arrays import Array, Int64, UInt16
from sceneq_nodes._image_file import MAX_PIXELS

MORE, BITS = 8, 3
MOST_GROUPS = 10
"""30 bits: enough for a run over the largest image; no depth needs as many."""
WORDS_AT_ONCE = 1 << 16
BYTES_PER_PIXEL, SPARE_BYTES = 4, 64
"""The most that a pixel may take, with its run; what lies beyond belongs to no pixel."""


def decode_rvl(data: bytes, size: tuple[int, int]) -> UInt16:
    """Return uint16 (H, W) for ``size`` (width, height).

    Raises:
        ValueError: too large, cut off, or damaged. Memory is bounded by the size, whatever the
            bytes say.
    """
    width, height = size
    count = width * height
    if width < 1 or height < 1 or count > MAX_PIXELS:
        raise ValueError(f"{width} x {height} pixels, the limit is {MAX_PIXELS}")
    numbers = _numbers(data[: BYTES_PER_PIXEL * count + SPARE_BYTES])
    at, first, held = _runs(numbers, count)
    values = _values(numbers, at, held)
    pixels = np.zeros(count, np.uint16)
    pixels[_places(first, held)] = values
    return pixels.reshape(height, width)


def _runs(numbers: Array, count: int) -> tuple[Int64, Int64, Int64]:
    """Return of every run the place of its first value, its first pixel and its length."""
    view, end = numbers.data, len(numbers)
    runs: list[tuple[int, int, int]] = []
    at = filled = 0
    while filled < count:
        if at + 2 > end:
            raise ValueError(f"RVL is cut off at pixel {filled} of {count}")
        zeros, held = view[at], view[at + 1]
        at, filled = at + 2, filled + zeros
        if not (zeros or held) or filled + held > count:
            raise ValueError(f"RVL is damaged at pixel {filled} of {count}")
        if at + held > end:
            raise ValueError(f"RVL is cut off at pixel {filled} of {count}")
        if held:
            runs.append((at, filled, held))
        at, filled = at + held, filled + held
    columns = np.array(runs, np.int64).reshape(-1, 3).T
    return columns[0], columns[1], columns[2]


def _values(numbers: Array, at: Int64, held: Int64) -> UInt16:
    """Return the depths of all runs, one after the other: each differs from the last by a step."""
    steps = numbers[_places(at, held)].astype(np.int64)
    # 0, -1, 1, -2, ... are written as 0, 1, 2, 3, ...
    values = np.cumsum((steps >> 1) ^ -(steps & 1))
    if values.min(initial=0) < 0 or values.max(initial=0) > np.iinfo(np.uint16).max:
        raise ValueError("RVL is damaged: a depth does not fit 16 bits")
    return values.astype(np.uint16)


def _places(first: Int64, held: Int64) -> Int64:
    """Return ``first``, ``first + 1``, ... of every run, ``held`` of each."""
    before = np.cumsum(held) - held
    return np.repeat(first - before, held) + np.arange(held.sum())


def _numbers(data: bytes) -> Array:
    """Return the numbers of variable length in ``data``, uint32; zeros at its end mean nothing."""
    words = np.frombuffer(data[: len(data) // 4 * 4], "<u4")
    found, rest = [np.zeros(0, np.uint32)], np.zeros(0, np.uint8)
    for start in range(0, len(words), WORDS_AT_ONCE):
        groups = np.concatenate((rest, _groups(words[start : start + WORDS_AT_ONCE])))
        ends = np.flatnonzero(groups < MORE)
        whole = int(ends[-1]) + 1 if len(ends) else 0
        found.append(_joined(groups[:whole], ends))
        rest = groups[whole:]
    return np.concatenate(found)


def _groups(words: Array) -> Array:
    shifts = np.arange(28, -4, -4, dtype=np.uint32)
    return ((words[:, None] >> shifts) & 0xF).astype(np.uint8).ravel()


def _joined(groups: Array, ends: Int64) -> Array:
    """Return the number of the groups up to each of ``ends``."""
    if not len(ends):
        return np.zeros(0, np.uint32)
    starts = np.concatenate(([0], ends[:-1] + 1))
    lengths = ends - starts + 1
    if lengths.max() > MOST_GROUPS:
        raise ValueError("RVL is damaged: a number of more than 30 bits")
    place = np.arange(len(groups)) - np.repeat(starts, lengths)
    bits = (groups & (MORE - 1)).astype(np.uint32) << (BITS * place).astype(np.uint32)
    return np.add.reduceat(bits, starts).astype(np.uint32)
