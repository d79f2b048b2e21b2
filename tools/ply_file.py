"""A coloured point cloud as a PLY file, which every viewer of point clouds reads."""

from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float32, UInt8

VERTEX = np.dtype(
    [*((axis, "<f4") for axis in "xyz"), *((c, "u1") for c in ("red", "green", "blue"))]
)
NAMES = {"f": "float", "u": "uchar"}


def write_ply(path: Path, points_world: Float32, rgb: UInt8) -> None:
    """Write points (N, 3) in metres with their colours (N, 3); raise ``OSError`` if it cannot."""
    vertex = np.empty(len(points_world), VERTEX)
    for values, names in ((points_world, ("x", "y", "z")), (rgb, ("red", "green", "blue"))):
        for column, name in enumerate(names):
            vertex[name] = values[:, column]
    properties = [f"property {NAMES[VERTEX[name].kind]} {name}" for name in VERTEX.names or ()]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertex)}"]
    header = "\n".join([*head, *properties, "end_header\n"])
    path.write_bytes(header.encode() + vertex.tobytes())
