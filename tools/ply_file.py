"""A coloured point cloud as a PLY file, which every viewer of point clouds reads."""

from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float32, Int32, UInt8

VERTEX = np.dtype(
    [*((axis, "<f4") for axis in "xyz"), *((c, "u1") for c in ("red", "green", "blue"))]
)
OWNED = np.dtype([*VERTEX.descr, ("instance_id", "<i4")])
NAMES = {"f": "float", "u": "uchar", "i": "int"}


def write_ply(
    path: Path, points_world: Float32, rgb: UInt8, instance_id: Int32 | None = None
) -> None:
    """Write points (N, 3) in metres with colours (N, 3) and, if given, instances (N,).

    Raises:
        OSError: the file cannot be written.
    """
    vertex = np.empty(len(points_world), VERTEX if instance_id is None else OWNED)
    if instance_id is not None:
        vertex["instance_id"] = instance_id
    for values, names in ((points_world, ("x", "y", "z")), (rgb, ("red", "green", "blue"))):
        for column, name in enumerate(names):
            vertex[name] = values[:, column]
    properties = [
        f"property {NAMES[vertex.dtype[name].kind]} {name}" for name in vertex.dtype.names or ()
    ]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertex)}"]
    header = "\n".join([*head, *properties, "end_header\n"])
    path.write_bytes(header.encode() + vertex.tobytes())
