"""sensor_msgs/PointCloud2 as columns, and back."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sceneq_core.arrays import Array, Bool, Float32
from sceneq_nodes.ros.typestore import WireError

KINDS = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 8: "f8"}
"""``datatype`` of a PointField -> numpy; the numbers are those of the message."""
TOO_FAR_M = 1e5
"""No LiDAR reaches that far; also what is not finite."""
NUMBERS = {kind: number for number, kind in KINDS.items()}


def cloud_columns(message: Any) -> dict[str, Array]:
    """Return every field by name, (N,) or (N, count), of all points.

    Raises:
        WireError: a field of an unknown type or outside its point, or too few bytes.
    """
    order = ">" if message.is_bigendian else "<"
    names, formats, offsets = [], [], []
    for field in message.fields:
        if field.datatype not in KINDS:
            raise WireError(f"point field '{field.name}': unknown datatype {field.datatype}")
        base = order + KINDS[field.datatype]
        formats.append(base if field.count <= 1 else (base, (int(field.count),)))
        names.append(field.name)
        offsets.append(int(field.offset))
    layout = {"names": names, "formats": formats, "offsets": offsets}
    try:
        point = np.dtype({**layout, "itemsize": int(message.point_step)})  # type: ignore[call-overload]
    except ValueError as error:
        raise WireError(f"point fields {names}: {error}") from error
    points = _points(message, point)
    return {name: points[name].astype(points[name].dtype.newbyteorder("=")) for name in names}


def cloud_xyz(message: Any) -> tuple[Float32, Bool]:
    """Return float32 (M, 3), metres, of the measured points, and which of all (N,) those are.

    Raises:
        WireError: as above, or there is no x, y or z.
    """
    columns = cloud_columns(message)
    if missing := {"x", "y", "z"} - set(columns):
        raise WireError(f"point cloud without {', '.join(sorted(missing))}")
    xyz = np.stack([columns[name].astype(np.float32) for name in "xyz"], axis=1)
    measured: Bool = (np.abs(xyz) < TOO_FAR_M).all(axis=1) & (xyz != 0).any(axis=1)
    return xyz[measured], measured


def cloud_fields(columns: Mapping[str, Array], point_field: Any) -> tuple[list[Any], int, Array]:
    """Return fields, point step and bytes, uint8 (N * step,), of columns (N,) in this order."""
    layout = np.dtype([(name, column.dtype.newbyteorder("<")) for name, column in columns.items()])
    points = np.empty(len(next(iter(columns.values()))), layout)
    fields = []
    for name, column in columns.items():
        points[name] = column
        kind, offset = layout.fields[name][:2]  # type: ignore[index]
        number = NUMBERS[kind.str.lstrip("<>|")]
        fields.append(point_field(name=name, offset=offset, datatype=number, count=1))
    return fields, layout.itemsize, points.view(np.uint8)


def packed_rgb(rgb: Array) -> Float32:
    """Return colours, uint8 (N, 3), as viewers of ROS expect: one float of the bits 0x00RRGGBB."""
    r, g, b = (rgb[:, i].astype(np.uint32) for i in range(3))
    return (r << 16 | g << 8 | b).view(np.float32)


def _points(message: Any, point: np.dtype[Any]) -> Array:
    height, width, step = int(message.height), int(message.width), int(message.row_step)
    row = width * point.itemsize
    data = np.frombuffer(message.data, np.uint8)
    if width * height == 0:
        return np.zeros(0, point)
    step = step or row
    if step < row or len(data) < step * (height - 1) + row:
        raise WireError(f"point cloud of {width}x{height} points with only {len(data)} bytes")
    rows = np.lib.stride_tricks.as_strided(data, (height, row), (step, 1), writeable=False)
    return np.ascontiguousarray(rows).reshape(-1).view(point)
