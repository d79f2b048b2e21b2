"""Poses on the wire as transforms between named frames."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from sceneq_core.ingest.frame_tree import StampedTransform

NS = 1_000_000_000


def stamp_ns(stamp: Any) -> int:
    """Return a builtin_interfaces/Time in nanoseconds."""
    return int(stamp.sec) * NS + int(stamp.nanosec)


def frame_name(name: str) -> str:
    """Return a frame without the leading slash of old programs; tf2 has none."""
    return name.lstrip("/")


def tf_transforms(message: Any, is_static: bool) -> Iterator[StampedTransform]:
    """Yield what a tf2_msgs/TFMessage says."""
    for stamped in message.transforms:
        moved = stamped.transform
        yield _transform(
            stamped.header, stamped.child_frame_id, moved.translation, moved.rotation, is_static
        )


def pose_transform(message: Any, child: str) -> StampedTransform:
    """Return a geometry_msgs/PoseStamped as the pose of ``child``."""
    return _transform(message.header, child, message.pose.position, message.pose.orientation)


def odometry_transform(message: Any, child: str) -> StampedTransform:
    """Return a nav_msgs/Odometry; of ``child`` where the message names no frame of its own."""
    pose = message.pose.pose
    child = message.child_frame_id or child
    return _transform(message.header, child, pose.position, pose.orientation)


def _transform(
    header: Any, child: str, at: Any, turned: Any, is_static: bool = False
) -> StampedTransform:
    return StampedTransform(
        stamp_ns=stamp_ns(header.stamp),
        parent=frame_name(header.frame_id),
        child=frame_name(child),
        xyz_m=np.array([at.x, at.y, at.z]),
        xyzw=np.array([turned.x, turned.y, turned.z, turned.w]),
        is_static=is_static,
    )
