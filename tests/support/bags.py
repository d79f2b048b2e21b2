"""Writes the slanted wall of ``seven_scenes`` as bags of ROS 1 and ROS 2, with ``rosbags``."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from sceneq_core.ingest.quaternion import quaternion_of

from support.data_sets import units
from support.seven_scenes import SIZE, K, color, pose

COLOUR, DEPTH = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"
START_NS = 5_000_000_000
STEP_NS = 100_000_000
TF = "tf2_msgs/msg/TFMessage"
OPTICAL = "camera_color_optical_frame"


class RosMaker:
    """Messages of the wall in the types of one version of ROS."""

    def __init__(self, version: int) -> None:
        self.version = version
        self.types = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
        if TF not in self.types.types:
            fields = "geometry_msgs/TransformStamped[] transforms"
            self.types.register(get_types_from_msg(fields, TF))

    def new(self, name: str, **fields: Any) -> Any:
        return self.types.types[name](**fields)

    def header(self, at_ns: int, frame: str) -> Any:
        sec, nanosec = divmod(at_ns, 1_000_000_000)
        stamp = self.new("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
        seq = {"seq": 0} if self.version == 1 else {}
        return self.new("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **seq)

    def image(self, at_ns: int, encoding: str, pixels: np.ndarray) -> Any:
        height, width = pixels.shape[:2]
        data = np.ascontiguousarray(pixels).view(np.uint8).ravel()
        return self.new(
            "sensor_msgs/msg/Image", header=self.header(at_ns, OPTICAL), height=height, width=width,
            encoding=encoding, is_bigendian=0, step=pixels.nbytes // height, data=data,
        )  # fmt: skip

    def jpeg(self, at_ns: int, rgb: np.ndarray) -> Any:
        data = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 100])[1].ravel()
        header = self.header(at_ns, OPTICAL)
        return self.new(
            "sensor_msgs/msg/CompressedImage", header=header, format="rgb8; jpeg", data=data
        )

    def camera_info(self, at_ns: int) -> Any:
        names = "DKRP" if self.version == 1 else "dkrp"
        values = (np.zeros(5), K.ravel(), np.eye(3).ravel(), np.hstack([K, np.zeros((3, 1))]))
        matrices = {name: np.ravel(value) for name, value in zip(names, values, strict=True)}
        roi = self.new(
            "sensor_msgs/msg/RegionOfInterest",
            x_offset=0, y_offset=0, height=0, width=0, do_rectify=False,
        )  # fmt: skip
        return self.new(
            "sensor_msgs/msg/CameraInfo", header=self.header(at_ns, OPTICAL), height=SIZE[1],
            width=SIZE[0], distortion_model="plumb_bob", binning_x=0, binning_y=0, roi=roi,
            **matrices,
        )  # fmt: skip

    def pose(self, matrix: np.ndarray) -> tuple[Any, Any]:
        """Return position and orientation."""
        x, y, z = matrix[:3, 3].tolist()
        turned = dict(zip("xyzw", quaternion_of(matrix[:3, :3]).tolist(), strict=True))
        turned = self.new("geometry_msgs/msg/Quaternion", **turned)
        return (x, y, z), turned

    def tf(self, at_ns: int, parent: str, child: str, matrix: np.ndarray) -> Any:
        (x, y, z), turned = self.pose(matrix)
        moved = self.new("geometry_msgs/msg/Vector3", x=x, y=y, z=z)
        stamped = self.new(
            "geometry_msgs/msg/TransformStamped", header=self.header(at_ns, parent),
            child_frame_id=child,
            transform=self.new("geometry_msgs/msg/Transform", translation=moved, rotation=turned),
        )  # fmt: skip
        return self.new(TF, transforms=[stamped])

    def pose_stamped(self, at_ns: int, matrix: np.ndarray) -> Any:
        (x, y, z), turned = self.pose(matrix)
        point = self.new("geometry_msgs/msg/Point", x=x, y=y, z=z)
        both = self.new("geometry_msgs/msg/Pose", position=point, orientation=turned)
        header = self.header(at_ns, "map")
        return self.new("geometry_msgs/msg/PoseStamped", header=header, pose=both)


def story(
    ros: RosMaker, count: int, poses: str = "tf", packed: bool = False, late_ns: int = 0
) -> Iterator[tuple[str, int, Any]]:
    """Yield topic, time and message; tf of a frame comes after its images, static tf at last.

    ``late_ns``: how much later than colour depth was taken.
    """
    suffix = "/compressed" if packed else ""
    for number in range(count):
        at_ns = START_NS + STEP_NS * number
        rgb = ros.jpeg(at_ns, color(number)) if packed else ros.image(at_ns, "rgb8", color(number))
        yield COLOUR + suffix, at_ns, rgb
        yield DEPTH, at_ns + 1, ros.image(at_ns + late_ns, "16UC1", units(number, 1000))
        for topic in (COLOUR, DEPTH):
            info = topic.replace("image_raw", "camera_info")
            yield info, at_ns + 2, ros.camera_info(at_ns)
        if poses == "tf":
            yield "/tf", at_ns + 3, ros.tf(at_ns, "map", "base_link", pose(number))
        if poses == "topic":
            yield "/pose", at_ns + 3, ros.pose_stamped(at_ns, pose(number))
    if poses == "tf":
        still = ros.tf(START_NS, "base_link", OPTICAL, np.eye(4))
        yield "/tf_static", START_NS + STEP_NS * count, still


def write_bag1(path: Path, count: int, **options: Any) -> Path:
    ros, connections = RosMaker(1), {}
    with Writer1(path) as writer:
        for topic, at_ns, message in story(ros, count, **options):
            name = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=ros.types)
            data = ros.types.serialize_ros1(message, name)
            writer.write(connections[topic], at_ns, data)
    return path


def write_bag2(path: Path, count: int, mcap: bool = False, **options: Any) -> Path:
    ros, connections = RosMaker(2), {}
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        for topic, at_ns, message in story(ros, count, **options):
            name = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, name, typestore=ros.types)
            data = ros.types.serialize_cdr(message, name)
            writer.write(connections[topic], at_ns, data)
    return path
