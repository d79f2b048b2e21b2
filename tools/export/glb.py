"""glTF 2.0 in one binary file: a named node for every instance, its points and its box.

glTF's y axis is up and its unit the metre (glTF 2.0 specification, 3.4): the root node turns the
world; the points themselves stay in the scene's frame.
"""

from pathlib import Path
from typing import Any

import numpy as np
import trimesh

from sceneq_core.arrays import Float32, Float64, UInt8
from sceneq_tools.errors import UserError
from sceneq_tools.export.scene import ExportedScene, Record, T_world_box, node_name
from sceneq_tools.export.upright import R_target_world

POINT_CLOUD: Any = trimesh.PointCloud  # untyped there
TURNED, REST = "scene", "no instance"
Y_AXIS = np.array([0.0, 1.0, 0.0])
KEPT = ("id", "label", "label_p", "p", "role", "state", "centre", "supported_by", "inside")


def write_glb(scene: ExportedScene, out: Path) -> list[Path]:
    """Write ``scene.glb``: what is known of an instance is in the extras of its node.

    Raises:
        UserError: the map is empty.
    """
    if not len(scene.cloud.points_world):
        raise UserError("glb: the map is empty")
    graph: Any = trimesh.Scene()
    graph.graph.update(frame_to=TURNED, matrix=_turned(scene))
    colours = scene.colours()
    for record, rows in scene.rows():
        _add_points(graph, node_name(record), scene.cloud.points_world[rows], colours[rows], record)
        _add_box(graph, record)
    rest = np.flatnonzero(scene.cloud.instance_id <= 0)
    if len(rest):
        _add_points(graph, REST, scene.cloud.points_world[rest], scene.cloud.rgb[rest], {})
    path = out / "scene.glb"
    path.write_bytes(graph.export(file_type="glb"))
    return [path]


def _turned(scene: ExportedScene) -> Float64:
    """Return T_gltf_world (4, 4)."""
    T_gltf_world = np.eye(4)
    T_gltf_world[:3, :3] = R_target_world(np.asarray(scene.cloud.up_world), Y_AXIS)
    return T_gltf_world


def _add_points(graph: Any, name: str, points_world: Float32, rgb: UInt8, record: Record) -> None:
    known = {key: record[key] for key in KEPT if key in record}
    cloud = POINT_CLOUD(points_world, np.ascontiguousarray(rgb), metadata=known)
    graph.add_geometry(
        cloud, node_name=name, geom_name=name, parent_node_name=TURNED, metadata=known
    )


def _add_box(graph: Any, record: Record) -> None:
    pose, size = T_world_box(record)
    corners = np.array(np.meshgrid(*[(-0.5, 0.5)] * 3, indexing="ij")).reshape(3, -1).T * size
    path = trimesh.load_path(corners[np.array(_edges())])
    name = f"{node_name(record)} box"
    graph.add_geometry(
        path, node_name=name, geom_name=name, parent_node_name=TURNED, transform=pose
    )


def _edges() -> list[tuple[int, int]]:
    """Return the pairs of corners, counted in binary by axis, that differ in one axis."""
    return [(a, a | bit) for bit in (1, 2, 4) for a in range(8) if not a & bit]
