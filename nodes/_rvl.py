"""Depth images compressed with RVL, as RTAB-Map and ROS' compressedDepth store them.

The image is runs: how many pixels are 0, how many are not, then the difference of each of these to
the one before it. A number is written in groups of three bits, the lowest first, each in four bits
whose highest says that more follow; eight of those make a little-endian 32-bit word, the first in
its highest bits.

Source: Wilson, "Fast Lossless Depth Image Compression", ISS 2017, DOI 10.1145/3132272.3134144.
"""

import numpy as np

from sceneq_core.arrays import Int64, UInt16

MORE, BITS = 8, 3


def decode_rvl(data: bytes, size: tuple[int, int]) -> UInt16:
    """Return uint16 (H, W) for ``size`` (width, height); ``ValueError`` when it is cut off."""
    width, height = size
    numbers = _numbers(data)
    pixels = np.zeros(width * height, np.int64)
    at, filled, last = 0, 0, 0
    while filled < len(pixels):
        if at + 2 > len(numbers):
            raise ValueError(f"RVL is cut off at pixel {filled} of {len(pixels)}")
        zeros, held = numbers[at : at + 2].tolist()
        filled, at = filled + zeros, at + 2
        steps = _signed(numbers[at : at + held])
        if len(steps) < held or filled + held > len(pixels):
            raise ValueError(f"RVL is cut off or damaged at pixel {filled} of {len(pixels)}")
        if held:
            values = last + np.cumsum(steps)
            pixels[filled : filled + held] = values
            last = int(values[-1])
        filled, at = filled + held, at + held
    if pixels.min(initial=0) < 0 or pixels.max(initial=0) > np.iinfo(np.uint16).max:
        raise ValueError("RVL is damaged: a depth does not fit 16 bits")
    return pixels.astype(np.uint16).reshape(height, width)


def _numbers(data: bytes) -> Int64:
    """Return the numbers of variable length in ``data``; zeros at its end mean nothing."""
    words = np.frombuffer(data[: len(data) // 4 * 4], "<u4")
    shifts = np.arange(28, -4, -4, dtype=np.uint32)
    groups = ((words[:, None] >> shifts) & 0xF).ravel().astype(np.int64)
    ends = np.flatnonzero(groups < MORE)
    if not len(ends):
        return ends
    groups = groups[: ends[-1] + 1]
    starts = np.concatenate(([0], ends[:-1] + 1))
    place = np.arange(len(groups)) - np.repeat(starts, ends - starts + 1)
    bits = (groups & (MORE - 1)) << np.minimum(BITS * place, 60)
    return np.add.reduceat(bits, starts)


def _signed(numbers: Int64) -> Int64:
    """Return the differences: 0, -1, 1, -2, ... are written as 0, 1, 2, 3, ..."""
    return (numbers >> 1) ^ -(numbers & 1)
