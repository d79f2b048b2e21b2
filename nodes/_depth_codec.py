"""Depth for a thin link: what changes from pixel to pixel, bytes of a kind together, then zstd.

Neighbouring depths differ by little, but their two bytes look random to a compressor as soon as
the sensor does not round: 450 KB of zstd for 640 x 480 with 2 mm of noise become 190 KB. Lossless.
"""

import numpy as np
import zstandard

from sceneq_core.arrays import UInt16

LEVEL = 1
SIGN_BIT = 15


def compressed_depth(depth_mm: UInt16) -> bytes:
    """Return uint16 (H, W) as bytes."""
    steps = depth_mm.copy()
    steps[:, 1:] -= depth_mm[:, :-1]  # modulo 2^16, as the way back
    folded = (steps << 1) ^ (0 - (steps >> SIGN_BIT))  # small steps of either sign: small numbers
    planes = np.stack([folded & 0xFF, folded >> 8]).astype(np.uint8)
    return zstandard.ZstdCompressor(level=LEVEL).compress(planes.tobytes())


def depth_from_planes(data: bytes, shape: tuple[int, ...]) -> UInt16:
    """Return the depth in the decompressed planes, uint16 of ``shape`` (H, W)."""
    low, high = np.frombuffer(data, np.uint8).reshape(2, *shape).astype(np.uint16)
    folded = low | (high << 8)
    steps = (folded >> 1) ^ (0 - (folded & 1))
    depth: UInt16 = np.cumsum(steps, axis=1, dtype=np.uint16)
    return depth
