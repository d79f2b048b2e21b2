"""Plays a recording as a ROS 2 robot would send it, in its own time, for whoever has no robot here.

    python play_as_robot.py RECORDING tcp/127.0.0.1:7447 [domain] [jazzy|humble|bridge]

Colour (bgr8), depth (16UC1), camera_info, /tf (map -> base) and the latched /tf_static
(base -> camera), in the exact form that rmw_zenoh, or zenoh-bridge-ros2dds, puts on the network.
"""

import json
import struct
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import zenoh
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from sceneq_core.ingest.source import Camera, RawFrame
from sceneq_nodes._backends import build
from sceneq_nodes._source_kinds import need_kind

COLOUR, DEPTH = "/camera/color", "/camera/aligned_depth_to_color"


class Robot:
    """Makes messages, and publishes them on the keys of one dialect."""

    def __init__(self, endpoint: str, domain: int, dialect: str) -> None:
        config = {"mode": "client", "connect": {"endpoints": [endpoint]}}
        config["timestamping"] = {"enabled": True}
        self.session = zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
        store = Stores.ROS2_HUMBLE if dialect == "humble" else Stores.ROS2_JAZZY
        self._store = get_typestore(store)
        self._domain, self._dialect, self._seq = domain, dialect, 0

    def make(self, kind: str, *fields: Any) -> Any:
        """Return a new message."""
        return self._store.types[kind](*fields)

    def header(self, stamp_ns: int, frame: str) -> Any:
        """Return a header."""
        stamp = self.make("builtin_interfaces/msg/Time", *divmod(stamp_ns, 10**9))
        return self.make("std_msgs/msg/Header", stamp, frame)

    def send(self, topic: str, message: Any, stamp_ns: int) -> None:
        """Publish a message; on a full link it waits, as it would not with best effort."""
        self.session.put(
            self.key(topic, message),
            self.data(message),
            attachment=self.note(stamp_ns),
            congestion_control=zenoh.CongestionControl.BLOCK,
        )

    def latch(self, topic: str, message: Any) -> Any:
        """Say it once, and again to everyone who asks later: TRANSIENT_LOCAL."""
        publisher = zenoh.ext.declare_advanced_publisher(
            self.session,
            self.key(topic, message),
            cache=zenoh.ext.CacheConfig(max_samples=1),
            publisher_detection=True,
        )
        publisher.put(self.data(message), attachment=self.note(0))
        return publisher

    def key(self, topic: str, message: Any) -> str:
        """Return the key of a topic in this dialect."""
        if self._dialect == "bridge":
            return topic[1:]
        package, _, name = message.__msgtype__.split("/")
        hashed = self._store.hash_rihs01(message.__msgtype__)
        hashed = "TypeHashNotSupported" if self._dialect == "humble" else hashed
        return f"{self._domain}{topic}/{package}::msg::dds_::{name}_/{hashed}"

    def data(self, message: Any) -> bytes:
        """Return the message as CDR."""
        return bytes(self._store.serialize_cdr(message, message.__msgtype__))

    def note(self, stamp_ns: int) -> bytes | None:
        """The attachment of rmw_zenoh: number, stamp, length and id of the writer."""
        self._seq += 1
        note = struct.pack("<qqB", self._seq, stamp_ns, 16) + bytes(range(16))
        return None if self._dialect == "bridge" else note

    def image(self, pixels: np.ndarray, encoding: str, stamp_ns: int) -> Any:
        """Return pixels (H, W) or (H, W, 3) as an image."""
        height, width = pixels.shape[:2]
        data = np.ascontiguousarray(pixels).view(np.uint8).reshape(-1)
        header = self.header(stamp_ns, "camera")
        return self.make(
            "sensor_msgs/msg/Image", header, height, width, encoding, 0, len(data) // height, data
        )

    def camera_info(self, camera: Camera, stamp_ns: int) -> Any:
        """Return a camera without distortion."""
        width, height = camera.size
        roi = self.make("sensor_msgs/msg/RegionOfInterest", 0, 0, 0, 0, False)
        k, p = camera.K.reshape(9), np.hstack([camera.K, np.zeros((3, 1))]).reshape(12)
        header, r = self.header(stamp_ns, "camera"), np.eye(3).reshape(9)
        fields = (header, height, width, "plumb_bob", np.zeros(5), k, r, p, 0, 0, roi)
        return self.make("sensor_msgs/msg/CameraInfo", *fields)

    def tf(self, parent: str, child: str, T_parent_child: np.ndarray, stamp_ns: int) -> Any:
        """Return where ``child`` is in ``parent``."""
        turn = Rotation.from_matrix(T_parent_child[:3, :3]).as_quat()
        moved = self.make(
            "geometry_msgs/msg/Transform",
            self.make("geometry_msgs/msg/Vector3", *map(float, T_parent_child[:3, 3])),
            self.make("geometry_msgs/msg/Quaternion", *map(float, turn)),
        )
        header = self.header(stamp_ns, parent)
        stamped = self.make("geometry_msgs/msg/TransformStamped", header, child, moved)
        return self.make("tf2_msgs/msg/TFMessage", [stamped])


def main(
    recording: str, endpoint: str = "tcp/127.0.0.1:7447", domain: str = "0", dialect: str = "jazzy"
) -> None:
    """Play every frame once."""
    kind = need_kind(Path(recording))
    source = build("source", {"kind": kind, "path": recording})
    robot = Robot(endpoint, int(domain), dialect)
    latched = robot.latch("/tf_static", robot.tf("base", "camera", np.eye(4), 0))
    frames = [frame for frame in source.frames() if isinstance(frame, RawFrame)]
    start_ns = time.time_ns()
    for frame in frames:
        now_ns = start_ns + frame.stamp_ns - frames[0].stamp_ns
        time.sleep(max(0.0, (now_ns - time.time_ns()) / 1e9))
        robot.send(f"{COLOUR}/camera_info", robot.camera_info(source.color_camera, now_ns), now_ns)
        robot.send("/tf", robot.tf("map", "base", frame.T_world_camera, now_ns), now_ns)
        colour = robot.image(frame.read_rgb()[..., ::-1], "bgr8", now_ns)
        robot.send(f"{COLOUR}/image_raw", colour, now_ns)
        depth = robot.image(frame.read_depth_mm(), "16UC1", now_ns)
        robot.send(f"{DEPTH}/image_raw", depth, now_ns)
    print(f"played {len(frames)} frames on domain {domain} ({dialect})")
    latched.undeclare()
    robot.session.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
