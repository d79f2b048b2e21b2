"""Every format, read back by the program or library that people read it with."""

import csv
import io
import json
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import cv2
import networkx
import numpy as np
import open3d
import pytest
import trimesh
import yaml
from pycocotools.coco import COCO

from sceneq_core.picture.scene import Cloud
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.scannet_text import read_predicted_text
from sceneq_tools.export.costmap import FREE, OCCUPIED, UNKNOWN, CostmapParams, write_costmap
from sceneq_tools.export.formats import FORMATS, write
from sceneq_tools.export.scene import ExportedScene, from_folder

UP = np.array([0.0, 0.0, 1.0])


def block(low: tuple[float, ...], high: tuple[float, ...], step: float = 0.05) -> np.ndarray:
    axes = [np.arange(a + step / 2, b, step) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3).astype(np.float32)


FLOOR = block((0, 0, -0.02), (2, 1, 0.0), 0.02)
TABLE = block((0.5, 0.2, 0.1), (1.0, 0.6, 0.7))
CUP = block((0.7, 0.3, 0.7), (0.8, 0.4, 0.8), 0.02)


def record(number: int, label: str, points: np.ndarray, **said: Any) -> dict[str, Any]:
    low, high = points.min(0).tolist(), points.max(0).tolist()
    centre = [(a + b) / 2 for a, b in zip(low, high, strict=True)]
    box = {
        "centre": centre,
        "size": [b - a for a, b in zip(low, high, strict=True)],
        "rotation": np.eye(3).tolist(),
    }
    key = f"sceneq/view/room/@image/v1?seq={number}"
    return {
        "id": number, "label": label, "p": 0.5, "label_p": 0.4, "role": "object",
        "state": "confirmed", "centre": centre, "box_aabb": {"min": low, "max": high},
        "box_oriented": box, "supported_by": None, "inside": None, "neighbours": [],
        "first_seen_ns": 1, "last_seen_ns": 2,
        "views": [{"seq": number, "key": key, "box_xyxy": [4.0, 6.0, 14.0, 26.0]}], **said,
    }  # fmt: skip


def scene(up_world: np.ndarray = UP, R_other_world: np.ndarray | None = None) -> ExportedScene:
    parts = (FLOOR, TABLE, CUP)
    records = [
        record(1, "floor", FLOOR, role="floor"),
        record(2, "table", TABLE, supported_by=1, neighbours=[3]),
        record(3, "aunt's mug", CUP, supported_by=2, neighbours=[2]),
    ]
    points = np.concatenate([*parts, [[1.9, 0.9, 1.5]]]).astype(np.float32)
    if R_other_world is not None:
        points = (points @ R_other_world.T).astype(np.float32)
    owner = np.repeat([1, 2, 3, 0], [*(len(p) for p in parts), 1]).astype(np.int32)
    rgb = np.full(points.shape, 90, np.uint8)
    document = {"scene": "room", "up_world": up_world.tolist(), "instances": records}
    picture = {r["views"][0]["key"]: jpeg() for r in records[1:]}
    return ExportedScene(Cloud(points, rgb, owner, 0.02, up_world), document, picture.get)


def jpeg() -> bytes:
    return cv2.imencode(".jpg", np.zeros((48, 64, 3), np.uint8))[1].tobytes()


def test_trimesh_reads_the_glb_with_named_nodes_and_y_up(tmp_path: Path) -> None:
    (path,) = write(scene(), ["glb"], tmp_path)
    read = trimesh.load_scene(path)
    assert {"table 2", "table 2 box", "aunt's mug 3", "no instance"} <= set(read.graph.nodes)
    T_gltf_world, name = read.graph.get("aunt's mug 3")
    points_gltf = trimesh.transform_points(read.geometry[name].vertices, T_gltf_world)
    np.testing.assert_allclose(points_gltf.mean(0), (0.75, 0.75, -0.35), atol=1e-5)
    corners = trimesh.transform_points(
        read.geometry[read.graph.get("table 2 box")[1]].vertices, read.graph.get("table 2 box")[0]
    )
    np.testing.assert_allclose(np.ptp(corners, axis=0), (0.45, 0.55, 0.35), atol=1e-5)
    said = {node["name"]: node.get("extras") for node in gltf(path)["nodes"]}
    assert said["table 2"]["supported_by"] == 1


def gltf(path: Path) -> Any:
    """Return the JSON chunk of a GLB, which follows 20 bytes of header."""
    data = path.read_bytes()
    return json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])


def test_networkx_reads_the_scene_graph(tmp_path: Path) -> None:
    (path,) = write(scene(), ["graph"], tmp_path)
    graph = networkx.node_link_graph(json.loads(path.read_text()), edges="edges")
    assert set(graph.edges(keys=True)) == {(2, 1, "on"), (3, 2, "on"), (2, 3, "next to")}
    assert graph.nodes[3]["label"] == "aunt's mug"


def test_the_table_has_a_line_for_every_instance(tmp_path: Path) -> None:
    (path,) = write(scene(), ["csv"], tmp_path)
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert [row["label"] for row in rows] == ["floor", "table", "aunt's mug"]
    assert rows[1]["points"] == str(len(TABLE))
    assert float(rows[1]["max_z_m"]) == pytest.approx(0.675)


def test_open3d_and_trimesh_read_the_points_and_their_instances(tmp_path: Path) -> None:
    (path,) = write(scene(), ["ply"], tmp_path)
    assert len(open3d.io.read_point_cloud(str(path)).points) == len(scene().cloud.points_world)
    table = open3d.t.io.read_point_cloud(str(path)).point["instance_id"].numpy().ravel()
    np.testing.assert_array_equal(table, scene().cloud.instance_id)


def test_scannets_text_has_a_mask_for_every_object(tmp_path: Path) -> None:
    listing, labels, cloud = write(scene(), ["scannet"], tmp_path)
    read = read_predicted_text(listing)
    count = len(trimesh.load(cloud).vertices)
    assert read.count == count == len(scene().cloud.points_world)
    assert read.names[0] == ("table",)
    np.testing.assert_array_equal(np.bincount(read.mask), [len(TABLE), len(CUP)])
    own = [n for n, name in json.loads(labels.read_text()).items() if name == "aunt's mug"]
    assert listing.read_text().splitlines()[1].split()[1:] == [own[0], "0.5000"]


def test_pycocotools_reads_the_boxes_of_the_evidence(tmp_path: Path) -> None:
    path, *images = write(scene(), ["coco"], tmp_path)
    with redirect_stdout(io.StringIO()):
        coco = COCO(str(path))
    assert [image.name for image in images] == ["000002.jpg", "000003.jpg"]
    (mug,) = coco.loadAnns(coco.getAnnIds(catIds=coco.getCatIds(catNms=["aunt's mug"])))
    assert mug["bbox"] == [4.0, 6.0, 10.0, 20.0]
    assert mug["attributes"]["instance_id"] == 3
    assert coco.loadImgs(mug["image_id"])[0]["width"] == 64
    assert json.loads(path.read_text())["info"]["views_without_image"] == 1


@pytest.mark.parametrize("tipped", [False, True])
def test_the_costmap_is_free_on_the_floor_and_blocked_by_the_table(
    tmp_path: Path, tipped: bool
) -> None:
    # Tipped: the real kitchen's way up, which is -y.
    turn = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]) if tipped else np.eye(3)
    settings, image, semantic, legend = write_costmap(
        scene(turn @ UP, turn), tmp_path, CostmapParams(resolution_m=0.1)
    )
    said, about = yaml.safe_load(settings.read_text()), json.loads(legend.read_text())
    cost, owner = cv2.imread(str(image), -1), cv2.imread(str(semantic), -1)

    def cell(x: float, y: float) -> tuple[int, int]:
        """As map_server has it: the last row of the image is the smallest y."""
        world = turn @ (x, y, 0)
        at = (np.array(about["R_map_world"]) @ world)[:2]
        column, row = np.floor((at - said["origin"][:2]) / said["resolution"]).astype(int)
        return cost.shape[0] - 1 - row, column

    assert cost[cell(0.75, 0.45)] == OCCUPIED
    assert about["cells"][str(owner[cell(0.75, 0.55)])] == {"id": 2, "label": "table"}
    assert cost[cell(1.55, 0.55)] == FREE
    assert UNKNOWN not in cost  # the floor was seen everywhere
    assert said["mode"] == "trinary"


def test_what_cannot_be_written_is_said(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"--as obj: unknown .*glb"):
        write(scene(), ["obj"], tmp_path)
    bare = ExportedScene(scene().cloud, scene().document)
    for name in ("native", "rrd", "coco"):
        with pytest.raises(UserError, match=f"{name}: .*running graph"):
            write(bare, [name], tmp_path)
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="cannot be written"):
        write(scene(), ["csv"], tmp_path / "file")


def test_an_empty_map_is_an_empty_table_and_no_model(tmp_path: Path) -> None:
    nothing = Cloud(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint8),
                    np.zeros(0, np.int32), 0.02, UP)  # fmt: skip
    empty = ExportedScene(nothing, {"scene": "room", "up_world": [0, 0, 1], "instances": []})
    for name in ("costmap", "glb"):
        with pytest.raises(UserError, match=f"{name}: the map is empty"):
            write(empty, [name], tmp_path)
    for name in set(FORMATS) - {"costmap", "glb", "native", "rrd", "coco"}:
        write(empty, [name], tmp_path)
    assert len((tmp_path / "instances.csv").read_text().splitlines()) == 1


def test_a_folder_of_ours_is_read_again(tmp_path: Path) -> None:
    ours = scene()
    cloud = ours.cloud
    np.savez(tmp_path / "instances.npz", points=cloud.points_world, rgb=cloud.rgb,
             instance_id=cloud.instance_id)  # fmt: skip
    (tmp_path / "instances.json").write_text(json.dumps({**ours.document, "voxel_size_m": 0.02}))
    again = from_folder(tmp_path)
    assert again.records == ours.records
    np.testing.assert_array_equal(again.cloud.points_world, cloud.points_world)
