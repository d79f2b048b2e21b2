"""The points as PLY, each with its instance."""

from pathlib import Path

from sceneq_tools.export.scene import ExportedScene
from sceneq_tools.ply_file import write_ply


def write_points(scene: ExportedScene, out: Path) -> list[Path]:
    """Write ``points.ply``: x y z in metres, colour of the camera, ``instance_id`` (0 = none)."""
    path = out / "points.ply"
    write_ply(path, scene.cloud.points_world, scene.cloud.rgb, scene.cloud.instance_id)
    return [path]
