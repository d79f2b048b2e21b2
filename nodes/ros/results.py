"""The instance map as ROS messages: detections, markers and a cloud with instance ids."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.quaternion import quaternion_of
from sceneq_core.mapping.delta import OBJECT, TENTATIVE, Instance
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.picture.colours import instance_colours
from sceneq_nodes.ros.point_cloud import cloud_fields, packed_rgb
from sceneq_nodes.ros.stamped_poses import NS
from sceneq_nodes.ros.typestore import Typestore

DETECTIONS = "vision_msgs/msg/Detection3DArray"
MARKERS = "visualization_msgs/msg/MarkerArray"
CLOUD = "sensor_msgs/msg/PointCloud2"
CUBE, TEXT, ADD, DELETE_ALL = 1, 9, 0, 3
"""``type`` and ``action`` of visualization_msgs/Marker."""
BOX_ALPHA = 0.35
TEXT_M = 0.12
WHITE = (1.0, 1.0, 1.0, 1.0)
UPRIGHT = np.eye(4)


@dataclass(frozen=True, slots=True)
class Name:
    """What an instance is called, with probability ``p``."""

    text: str
    p: float


class Results:
    """Makes messages of one map in the frame ``frame_id``."""

    def __init__(self, store: Typestore, frame_id: str, max_points: int) -> None:
        self._make = store.make
        self._frame_id = frame_id
        self._max_points = max_points

    def detections(self, replica: MapReplica, names: Mapping[int, Name]) -> Any:
        """Return a vision_msgs/Detection3DArray: every object with its box, its id and its name.

        An object without a name has no hypothesis.
        """
        header = self._header(replica.stamp_ns)
        found = [self._detection(header, one, names) for one in objects(replica)]
        return self._make(DETECTIONS, header=header, detections=found)

    def markers(self, replica: MapReplica, names: Mapping[int, Name]) -> Any:
        """Return a visualization_msgs/MarkerArray: a box and a name each, all others deleted."""
        header = self._header(replica.stamp_ns)
        shown = [self._marker(header, "all", 0, DELETE_ALL, UPRIGHT, np.ones(3), WHITE)]
        for one in objects(replica):
            key, name = one.instance_id, names.get(one.instance_id)
            colour = (*_colour(key), BOX_ALPHA)
            box = one.T_world_box
            shown.append(self._marker(header, "boxes", key, ADD, box, one.box_size_m, colour))
            above = _raised(box, one.aabb_world, replica.up_world)
            size = np.array([0.0, 0.0, TEXT_M])
            label = str(key) if name is None else f"{key} {name.text}"
            shown.append(self._marker(header, "names", key, ADD, above, size, WHITE, label))
        return self._make(MARKERS, markers=shown)

    def cloud(self, replica: MapReplica) -> Any:
        """Return a sensor_msgs/PointCloud2 with x y z rgb instance_id (0 = none).

        Of a larger map than ``max_points`` every second, third, ... point.
        """
        points, rgb, instance_id = replica.cloud()
        step = max(1, -(-len(points) // self._max_points))
        points, rgb, instance_id = points[::step], rgb[::step], instance_id[::step]
        columns = {axis: points[:, i] for i, axis in enumerate("xyz")}
        columns |= {"rgb": packed_rgb(rgb), "instance_id": instance_id.astype(np.uint32)}
        point_field = partial(self._make, "sensor_msgs/msg/PointField")
        fields, point_step, data = cloud_fields(columns, point_field)
        return self._make(
            CLOUD,
            header=self._header(replica.stamp_ns),
            height=1,
            width=len(points),
            fields=fields,
            is_bigendian=False,
            point_step=point_step,
            row_step=point_step * len(points),
            data=data,
            is_dense=True,
        )

    def _detection(self, header: Any, one: Instance, names: Mapping[int, Name]) -> Any:
        pose = self._pose(one.T_world_box)
        name = names.get(one.instance_id)
        box = self._make(
            "vision_msgs/msg/BoundingBox3D", center=pose, size=self._vector(one.box_size_m)
        )
        results = [] if name is None else [self._hypothesis(name, pose)]
        return self._make(
            "vision_msgs/msg/Detection3D",
            header=header,
            results=results,
            bbox=box,
            id=str(one.instance_id),
        )

    def _hypothesis(self, name: Name, pose: Any) -> Any:
        return self._make(
            "vision_msgs/msg/ObjectHypothesisWithPose",
            hypothesis=self._make(
                "vision_msgs/msg/ObjectHypothesis", class_id=name.text, score=float(name.p)
            ),
            pose=self._make(
                "geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=np.zeros(36)
            ),
        )

    def _marker(
        self,
        header: Any,
        namespace: str,
        number: int,
        action: int,
        T_world_marker: Float64,
        size_m: Float64,
        rgba: Sequence[float],
        text: str = "",
    ) -> Any:
        make = self._make
        return make(
            "visualization_msgs/msg/Marker",
            header=header,
            ns=namespace,
            id=number,
            type=TEXT if text else CUBE,
            action=action,
            pose=self._pose(T_world_marker),
            scale=self._vector(size_m),
            color=make("std_msgs/msg/ColorRGBA", **dict(zip("rgba", rgba, strict=True))),
            lifetime=make("builtin_interfaces/msg/Duration", sec=0, nanosec=0),
            frame_locked=False,
            points=[],
            colors=[],
            texture_resource="",
            texture=make(
                "sensor_msgs/msg/CompressedImage",
                header=header,
                format="",
                data=np.zeros(0, np.uint8),
            ),
            uv_coordinates=[],
            text=text,
            mesh_resource="",
            mesh_file=make("visualization_msgs/msg/MeshFile", filename="", data=np.zeros(0, "u1")),
            mesh_use_embedded_materials=False,
        )

    def _header(self, stamp_ns: int) -> Any:
        stamp = self._make("builtin_interfaces/msg/Time", sec=stamp_ns // NS, nanosec=stamp_ns % NS)
        return self._make("std_msgs/msg/Header", stamp=stamp, frame_id=self._frame_id)

    def _pose(self, T_world_box: Float64) -> Any:
        x, y, z = map(float, T_world_box[:3, 3])
        turned = dict(zip("xyzw", map(float, quaternion_of(T_world_box[:3, :3])), strict=True))
        return self._make(
            "geometry_msgs/msg/Pose",
            position=self._make("geometry_msgs/msg/Point", x=x, y=y, z=z),
            orientation=self._make("geometry_msgs/msg/Quaternion", **turned),
        )

    def _vector(self, xyz: Float64) -> Any:
        x, y, z = map(float, xyz)
        return self._make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)


def objects(replica: MapReplica) -> list[Instance]:
    """Return the instances that are sure enough to be told, by id; floor and walls are none."""
    every = [replica.instances[key] for key in sorted(replica.instances)]
    return [one for one in every if one.role == OBJECT and one.state != TENTATIVE]


def _colour(instance_id: int) -> tuple[float, float, float]:
    white = np.full((1, 3), 255, np.uint8)
    r, g, b = instance_colours(np.array([instance_id], np.int32), white)[0] / 255
    return float(r), float(g), float(b)


def _raised(T_world_box: Float64, aabb_world: Float64, up_world: Float64) -> Float64:
    """Return where the name stands: upright, above the top of the box."""
    top = UPRIGHT.copy()
    half_m = float(np.abs((aabb_world[1] - aabb_world[0]) @ np.abs(up_world))) / 2
    top[:3, 3] = T_world_box[:3, 3] + up_world * (half_m + TEXT_M)
    return top
