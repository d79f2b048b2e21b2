"""What is in a recording: messages of ROS 2, two of them our own.

    /sceneq/color/image_raw              sensor_msgs/Image rgb8, or .../compressed
                                         sensor_msgs/CompressedImage jpeg: bytes as on the bus
    /sceneq/depth/image_raw              sensor_msgs/Image 16UC1, millimetres
    /sceneq/color/camera_info            sensor_msgs/CameraInfo of both
    /sceneq/keyframe                     sceneq_msgs/Keyframe: seq, and the pose exactly; comes last
    /tf                                  tf2_msgs/TFMessage: the pose of every frame
    /sceneq/{correction,masks,map}       sceneq_msgs/Packed: the message of the bus as it was
    /sceneq/answers                      std_msgs/String: an answer as JSON

A quaternion cannot say a rotation to the last bit, so the keyframe holds the matrix itself.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from sceneq_core.arrays import Float64
from sceneq_nodes._images import array_from_image
from sceneq_schemas.frame import Frame, Pose

COLOR, COLOR_JPEG = "/sceneq/color/image_raw", "/sceneq/color/image_raw/compressed"
DEPTH, CAMERA = "/sceneq/depth/image_raw", "/sceneq/color/camera_info"
KEYFRAME, TF = "/sceneq/keyframe", "/tf"
CORRECTION, MASKS, MAP = "/sceneq/correction", "/sceneq/masks", "/sceneq/map"
ANSWERS = "/sceneq/answers"

KEYFRAME_TYPE, PACKED_TYPE = "sceneq_msgs/msg/Keyframe", "sceneq_msgs/msg/Packed"
OURS = {
    KEYFRAME_TYPE: (
        "# A keyframe of Scene-Q. Its images and camera have the same stamp.\n"
        "std_msgs/Header header\n"
        "int64 seq\n"
        "# 4x4, row by row: camera (x right, y down, z ahead) to world, metres.\n"
        "float64[16] t_world_camera\n"
    ),
    PACKED_TYPE: (
        "# A message of Scene-Q's bus: msgpack of a schema such as sceneq.map.v1.\n"
        "std_msgs/Header header\n"
        "string schema\n"
        "uint8[] data\n"
    ),
}
WORLD, CAMERA_FRAME = "world", "camera"
NS_PER_S = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Said:
    """A message on a topic, to be written at ``stamp_ns``."""

    topic: str
    type_name: str
    stamp_ns: int
    message: Any


@cache
def store() -> Typestore:
    """Return the types of ROS 2 and ours; making it takes some ten milliseconds."""
    types = get_typestore(Stores.ROS2_JAZZY)
    for name, definition in OURS.items():
        types.register(get_types_from_msg(definition, name))
    return types


def keyframe_said(frame: Frame) -> Iterator[Said]:
    """Yield the messages of a keyframe; the one that makes it complete is the last."""
    yield _color(frame)
    yield _depth(frame)
    yield _camera_info(frame)
    message = _new(
        KEYFRAME_TYPE,
        header=_header(frame.stamp_ns),
        seq=frame.seq,
        t_world_camera=np.ascontiguousarray(frame.T_world_camera, np.float64).ravel(),
    )
    yield Said(KEYFRAME, KEYFRAME_TYPE, frame.stamp_ns, message)


def pose_said(pose: Pose) -> Said:
    """Return the pose of a frame as a transform."""
    stamped = _new(
        "geometry_msgs/msg/TransformStamped",
        header=_header(pose.stamp_ns, WORLD),
        child_frame_id=CAMERA_FRAME,
        transform=_transform(pose.T_world_camera),
    )
    message = _new("tf2_msgs/msg/TFMessage", transforms=[stamped])
    return Said(TF, "tf2_msgs/msg/TFMessage", pose.stamp_ns, message)


def packed_said(topic: str, schema: str, data: bytes, stamp_ns: int) -> Said:
    """Return a message of the bus as it is."""
    pixels = np.frombuffer(data, np.uint8)
    message = _new(PACKED_TYPE, header=_header(stamp_ns), schema=schema, data=pixels)
    return Said(topic, PACKED_TYPE, stamp_ns, message)


def answer_said(text: str, stamp_ns: int) -> Said:
    """Return an answer, JSON."""
    return Said(ANSWERS, "std_msgs/msg/String", stamp_ns, _new("std_msgs/msg/String", data=text))


def _color(frame: Frame) -> Said:
    image = frame.rgb
    if image.codec == "jpeg":
        name = "sensor_msgs/msg/CompressedImage"
        data = np.frombuffer(image.data, np.uint8)
        message = _new(name, header=_header(frame.stamp_ns), format="jpeg", data=data)
        return Said(COLOR_JPEG, name, frame.stamp_ns, message)
    return _image(COLOR, "rgb8", array_from_image(image), frame.stamp_ns)


def _depth(frame: Frame) -> Said:
    return _image(DEPTH, "16UC1", array_from_image(frame.depth_mm), frame.stamp_ns)


def _image(topic: str, encoding: str, pixels: Any, stamp_ns: int) -> Said:
    height, width = pixels.shape[:2]
    message = _new(
        "sensor_msgs/msg/Image",
        header=_header(stamp_ns),
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=0,
        step=pixels.nbytes // height,
        data=np.ascontiguousarray(pixels).view(np.uint8).ravel(),
    )
    return Said(topic, "sensor_msgs/msg/Image", stamp_ns, message)


def _camera_info(frame: Frame) -> Said:
    height, width = frame.rgb.shape[:2]
    K = np.ascontiguousarray(frame.K, np.float64)
    roi = "sensor_msgs/msg/RegionOfInterest"
    message = _new(
        "sensor_msgs/msg/CameraInfo",
        header=_header(frame.stamp_ns),
        height=height,
        width=width,
        distortion_model="plumb_bob",
        d=np.zeros(5),
        k=K.ravel(),
        r=np.eye(3).ravel(),
        p=np.hstack([K, np.zeros((3, 1))]).ravel(),
        binning_x=0,
        binning_y=0,
        roi=_new(roi, x_offset=0, y_offset=0, height=0, width=0, do_rectify=False),
    )
    return Said(CAMERA, "sensor_msgs/msg/CameraInfo", frame.stamp_ns, message)


def _transform(T_world_camera: Float64) -> Any:
    from sceneq_core.ingest.quaternion import quaternion_of

    x, y, z = T_world_camera[:3, 3].tolist()
    qx, qy, qz, qw = quaternion_of(T_world_camera[:3, :3]).tolist()
    return _new(
        "geometry_msgs/msg/Transform",
        translation=_new("geometry_msgs/msg/Vector3", x=x, y=y, z=z),
        rotation=_new("geometry_msgs/msg/Quaternion", x=qx, y=qy, z=qz, w=qw),
    )


def _header(stamp_ns: int, frame: str = CAMERA_FRAME) -> Any:
    sec, nanosec = divmod(stamp_ns, NS_PER_S)
    stamp = _new("builtin_interfaces/msg/Time", sec=sec, nanosec=nanosec)
    return _new("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def _new(type_name: str, **fields: Any) -> Any:
    return store().types[type_name](**fields)
