"""The one table of what can be exported."""

from collections.abc import Callable, Mapping
from pathlib import Path

from sceneq_tools.errors import UserError
from sceneq_tools.export.coco import write_coco
from sceneq_tools.export.costmap import write_costmap
from sceneq_tools.export.glb import write_glb
from sceneq_tools.export.graph_json import write_graph
from sceneq_tools.export.points import write_points
from sceneq_tools.export.scannet import write_scannet
from sceneq_tools.export.scene import ExportedScene
from sceneq_tools.export.tables import write_csv
from sceneq_tools.scene_files import SceneFiles

Writer = Callable[[ExportedScene, Path], list[Path]]


def write_native(scene: ExportedScene, out: Path) -> list[Path]:
    """Write instances.npz, instances.json, cloud.ply and instances.png, which we read again."""
    files = _need_graph(scene, "native")
    files.write(out)
    names = ("instances.npz", "instances.json", "cloud.ply", "instances.png")
    return [out / name for name in names if (out / name).exists()]


def write_rrd(scene: ExportedScene, out: Path) -> list[Path]:
    """Write ``scene.rrd`` for the Rerun viewer."""
    from sceneq_tools.rerun_file import write_rerun

    path = out / "scene.rrd"
    write_rerun(_need_graph(scene, "rrd"), path)
    return [path]


FORMATS: Mapping[str, Writer] = {
    "native": write_native,
    "ply": write_points,
    "glb": write_glb,
    "graph": write_graph,
    "csv": write_csv,
    "scannet": write_scannet,
    "coco": write_coco,
    "costmap": write_costmap,
    "rrd": write_rrd,
}


def write(scene: ExportedScene, formats: list[str], out: Path) -> list[Path]:
    """Write the scene in each of the formats into ``out`` and return the files.

    Raises:
        UserError: no such format, one that this scene cannot be written in, or no place to write.
    """
    if unknown := [name for name in formats if name not in FORMATS]:
        raise UserError(f"--as {unknown[0]}: unknown (known: {', '.join(FORMATS)})", 2)
    try:
        out.mkdir(parents=True, exist_ok=True)
        return [path for name in formats for path in FORMATS[name](scene, out)]
    except OSError as error:
        raise UserError(f"{out}: cannot be written: {error.strerror or error}", 2) from error


def _need_graph(scene: ExportedScene, name: str) -> SceneFiles:
    if scene.files is None:
        raise UserError(f"{name}: export it from a running graph, not from a folder", 2)
    return scene.files
