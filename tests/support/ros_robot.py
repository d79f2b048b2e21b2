"""What a ROS 2 robot would put on the wire, made with ``rosbags`` alone: bytes, keys, attachments.

Nothing of ours is used here, so that the tests compare two implementations.
"""

import struct
from collections.abc import Iterator
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_typestore

NS = 1_000_000_000
IMAGE, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"
COMPRESSED, CLOUD = "sensor_msgs/msg/CompressedImage", "sensor_msgs/msg/PointCloud2"
TF, ODOMETRY = "tf2_msgs/msg/TFMessage", "nav_msgs/msg/Odometry"
POSE = "geometry_msgs/msg/PoseStamped"
GID = bytes(range(16))


class Robot:
    """Messages of one distribution, and the keys that a dialect gives them."""

    def __init__(self, distro: str = "jazzy", dialect: str = "jazzy", domain: int = 7) -> None:
        self.store = get_typestore(getattr(Stores, f"ROS2_{distro.upper()}"))
        self.types = self.store.types
        self._dialect, self._domain = dialect, domain
        self._seq = 0

    def key(self, topic: str, kind: str) -> str:
        if self._dialect == "bridge":
            return topic[1:]
        package, _, name = kind.split("/")
        type_hash = self.store.hash_rihs01(kind)
        if self._dialect == "humble":
            type_hash = "TypeHashNotSupported"
        return f"{self._domain}{topic}/{package}::msg::dds_::{name}_/{type_hash}"

    def attachment(self, stamp_ns: int) -> bytes:
        if self._dialect == "bridge":
            return b""
        self._seq += 1
        return struct.pack("<qqB", self._seq, stamp_ns, 16) + GID

    def data(self, message: Any) -> bytes:
        return bytes(self.store.serialize_cdr(message, message.__msgtype__))

    def header(self, stamp_ns: int, frame: str) -> Any:
        time = self.types["builtin_interfaces/msg/Time"](stamp_ns // NS, stamp_ns % NS)
        return self.types["std_msgs/msg/Header"](time, frame)

    def image(
        self,
        pixels: np.ndarray,
        encoding: str,
        stamp_ns: int = 0,
        frame: str = "camera",
        padding: int = 0,
    ) -> Any:
        """``pixels`` in the byte order they are sent in; ``padding`` bytes end every row."""
        rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(len(pixels), -1)
        rows = np.pad(rows, ((0, 0), (0, padding)), constant_values=171)
        return self.types[IMAGE](
            header=self.header(stamp_ns, frame),
            height=pixels.shape[0],
            width=pixels.shape[1],
            encoding=encoding,
            is_bigendian=int(pixels.dtype.byteorder == ">"),
            step=rows.shape[1],
            data=rows.reshape(-1),
        )

    def compressed(self, data: bytes, text: str, stamp_ns: int = 0, frame: str = "camera") -> Any:
        array = np.frombuffer(data, np.uint8)
        return self.types[COMPRESSED](self.header(stamp_ns, frame), text, array)

    def info(
        self,
        K: np.ndarray,
        size: tuple[int, int],
        model: str = "plumb_bob",
        d: tuple[float, ...] = (0.0,) * 5,
        stamp_ns: int = 0,
        frame: str = "camera",
        **other: Any,
    ) -> Any:
        roi = self.types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
        fields = {
            "header": self.header(stamp_ns, frame),
            "height": size[1],
            "width": size[0],
            "distortion_model": model,
            "d": np.array(d, np.float64),
            "k": K.reshape(9).astype(np.float64),
            "r": np.eye(3).reshape(9),
            "p": np.hstack([K, np.zeros((3, 1))]).reshape(12),
            "binning_x": 0,
            "binning_y": 0,
            "roi": roi,
        }
        return self.types[INFO](**(fields | other))

    def tf(self, *transforms: tuple[int, str, str, np.ndarray, np.ndarray]) -> Any:
        """Each is stamp_ns, parent, child, translation and quaternion x y z w."""
        stamped = self.types["geometry_msgs/msg/TransformStamped"]
        transform = self.types["geometry_msgs/msg/Transform"]
        return self.types[TF](
            [
                stamped(self.header(ns, parent), child, transform(self._vector(t), self._turn(q)))
                for ns, parent, child, t, q in transforms
            ]
        )

    def pose(self, t: np.ndarray, q: np.ndarray, stamp_ns: int, frame: str = "map") -> Any:
        return self.types[POSE](self.header(stamp_ns, frame), self._pose(t, q))

    def odometry(
        self, t: np.ndarray, q: np.ndarray, stamp_ns: int, frame: str = "odom", child: str = "base"
    ) -> Any:
        covariance, zero = np.zeros(36), self._vector((0.0, 0.0, 0.0))
        twist = self.types["geometry_msgs/msg/Twist"](zero, zero)
        return self.types[ODOMETRY](
            self.header(stamp_ns, frame),
            child,
            self.types["geometry_msgs/msg/PoseWithCovariance"](self._pose(t, q), covariance),
            self.types["geometry_msgs/msg/TwistWithCovariance"](twist, covariance),
        )

    def cloud(
        self, columns: dict[str, np.ndarray], stamp_ns: int = 0, frame: str = "lidar", pad: int = 0
    ) -> Any:
        """One row of points with ``pad`` unused bytes after each."""
        numbers = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}
        offsets = np.cumsum([0, *(column.dtype.itemsize for column in columns.values())])
        layout = np.dtype(
            {
                "names": list(columns),
                "formats": [column.dtype for column in columns.values()],
                "offsets": offsets[:-1].tolist(),
                "itemsize": int(offsets[-1]) + pad,
            }
        )
        points = np.zeros(len(next(iter(columns.values()))), layout)
        for name, column in columns.items():
            points[name] = column
        field = self.types["sensor_msgs/msg/PointField"]
        fields = [
            field(name, int(offset), numbers[column.dtype.str[1:]], 1)
            for (name, column), offset in zip(columns.items(), offsets, strict=False)
        ]
        return self.types[CLOUD](
            header=self.header(stamp_ns, frame),
            height=1,
            width=len(points),
            fields=fields,
            is_bigendian=False,
            point_step=layout.itemsize,
            row_step=layout.itemsize * len(points),
            data=points.view(np.uint8).reshape(-1),
            is_dense=False,
        )

    def _pose(self, t: np.ndarray, q: np.ndarray) -> Any:
        point = self.types["geometry_msgs/msg/Point"](*map(float, t))
        return self.types["geometry_msgs/msg/Pose"](point, self._turn(q))

    def _vector(self, t: Any) -> Any:
        return self.types["geometry_msgs/msg/Vector3"](*map(float, t))

    def _turn(self, q: Any) -> Any:
        return self.types["geometry_msgs/msg/Quaternion"](*map(float, q))


def stamps_ns(count: int, start_ns: int = 1_700_000_000 * NS, rate_hz: float = 10) -> Iterator[int]:
    """Capture times of a camera."""
    for k in range(count):
        yield start_ns + round(k * NS / rate_hz)
