"""What `sceneq map` and `sceneq export` leave on disk."""

import json
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32, Int32
from sceneq_core.mapping.delta import OBJECT
from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.picture import instance_colours
from sceneq_core.picture.scene import Cloud
from sceneq_core.picture.sheet import SIZE
from sceneq_tools.errors import UserError
from sceneq_tools.ply_file import write_ply
from sceneq_tools.scene_picture import scene_picture, write_png

ARRAYS_FILE, RECORDS_FILE = "instances.npz", "instances.json"


@dataclass(frozen=True, slots=True)
class Descriptors:
    """Descriptors (D,) and image features (F,) by instance id, of the encoder ``model``."""

    model: str
    rows: Mapping[int, Float32]
    features: Mapping[int, Float32]

    def arrays(self) -> tuple[Int32, Float32, Float32]:
        """Return ids int32 (N,), sorted, descriptors float32 (N, D) and features (N, F)."""
        ids = sorted(self.rows)
        return np.array(ids, np.int32), _stacked(self.rows, ids), _stacked(self.features, ids)


def _stacked(rows: Mapping[int, Float32], ids: Sequence[int]) -> Float32:
    return np.stack([rows[key] for key in ids]) if ids else np.zeros((0, 0), np.float32)


def no_descriptors(model: str = "") -> Descriptors:
    """Return what a scene without an encoder has."""
    return Descriptors(model, {}, {})


@dataclass(frozen=True, slots=True)
class SceneFiles:
    """A map ready to be written: points (N, 3) metres, colours, instance ids and their records.

    ``instances`` are the records that the scene lists (id, label, p, centre, boxes, views);
    ``descriptors`` what questions are answered from.
    """

    scene: str
    label_set: str
    replica: MapReplica
    instances: tuple[Mapping[str, Any], ...]
    descriptors: Descriptors = field(default_factory=no_descriptors)

    def write(self, out: Path, picture_size: tuple[int, int] = SIZE) -> dict[str, Any]:
        """Write all files into ``out`` and return the summary that is also in instances.json.

        ``picture_size`` is that of instances.png, (width, height) in pixels.

        Of an empty map there is neither cloud.ply nor instances.png.

        Raises:
            OSError: the folder cannot be made or written.
        """
        out.mkdir(parents=True, exist_ok=True)
        cloud = self.cloud()
        document = self.document(cloud)
        (out / RECORDS_FILE).write_text(json.dumps(document, indent=1, ensure_ascii=False))
        with (
            ThreadPoolExecutor() as pool
        ):  # compressing, like most of drawing, is not Python's work
            arrays = pool.submit(self._write_arrays, cloud, out)
            if len(cloud.points_world):
                colours = instance_colours(cloud.instance_id, cloud.rgb)
                points = pool.submit(write_ply, out / "cloud.ply", cloud.points_world, colours)
                picture = scene_picture(cloud, document, size=picture_size)
                write_png(picture, out / "instances.png")
                points.result()
            arrays.result()
        return document

    def _write_arrays(self, cloud: Cloud, out: Path) -> None:
        described_id, descriptor, feature = self.descriptors.arrays()
        np.savez_compressed(
            out / ARRAYS_FILE,
            points=cloud.points_world,
            instance_id=cloud.instance_id,
            rgb=cloud.rgb,
            described_id=described_id,
            descriptor=descriptor,
            feature=feature,
        )

    def cloud(self) -> Cloud:
        """Return the points of the map."""
        replica = self.replica
        return Cloud(*replica.cloud(), replica.voxel_size_m, replica.up_world)

    def document(self, cloud: Cloud) -> dict[str, Any]:
        """Return what instances.json holds: a summary, the scene graph and the instances."""
        return {
            **self._summary(cloud.points_world, cloud.instance_id),
            "scene_graph": scene_graph(self.instances),
            "instances": list(self.instances),
        }

    def _summary(self, points_world: Float32, instance_id: Int32) -> dict[str, Any]:
        coord = np.floor(points_world / self.replica.voxel_size_m).astype(np.int32)
        return {
            "scene": self.scene,
            "label_set": self.label_set,
            "model": self.descriptors.model,
            "frame_seq": self.replica.frame_seq,
            "voxel_size_m": self.replica.voxel_size_m,
            "up_world": [round(float(x), 4) for x in self.replica.up_world],
            "points": len(points_world),
            "instance_count": len(np.unique(instance_id[instance_id > 0])),
            "digest": map_digest(coord, points_world, instance_id),
        }


def scene_graph(records: Iterable[Mapping[str, Any]]) -> dict[str, Any]:
    """Return an overview of what the records say about each other, by instance ids.

    ``structure`` lists the parts of the building by role, ``carries`` and ``contains`` what is on
    and in an instance, ``unsupported`` the objects of which it is not known what carries them.
    """
    graph: dict[str, Any] = {"structure": {}, "carries": {}, "contains": {}, "unsupported": []}
    for record in records:
        number, role = record["id"], record.get("role", OBJECT)
        if role != OBJECT:
            graph["structure"].setdefault(role, []).append(number)
        elif record.get("supported_by"):
            graph["carries"].setdefault(str(record["supported_by"]), []).append(number)
        else:
            graph["unsupported"].append(number)
        if record.get("inside"):
            graph["contains"].setdefault(str(record["inside"]), []).append(number)
    return graph


def read_scene(folder: Path) -> tuple[Cloud, dict[str, Any]]:
    """Return points and records of a scene from a folder that was written like this.

    Raises:
        UserError: it was not, or not completely.
    """
    try:
        document = json.loads((folder / RECORDS_FILE).read_text())
        with np.load(folder / ARRAYS_FILE) as arrays:
            points_world, instance_id = arrays["points"], arrays["instance_id"]
            rgb = arrays["rgb"] if "rgb" in arrays else np.full(points_world.shape, 160, np.uint8)
        up_world = np.asarray(document["up_world"], np.float64)
        cloud = Cloud(points_world, rgb, instance_id, document["voxel_size_m"], up_world)
    except FileNotFoundError as error:
        hint = "write one: sceneq map RECORDING FOLDER"
        raise UserError(f"{folder}: no {Path(error.filename).name} in it ({hint})", 2) from error
    except (OSError, ValueError, KeyError) as error:
        raise UserError(f"{folder}: cannot be read: {error}", 2) from error
    return cloud, document


def read_descriptors(folder: Path) -> Descriptors:
    """Return the descriptors of a scene from a folder that was written like this.

    Raises:
        UserError: it was not, or by a version that did not keep them.
    """
    try:
        document = json.loads((folder / RECORDS_FILE).read_text())
        with np.load(folder / ARRAYS_FILE) as arrays:
            ids = arrays["described_id"].tolist()
            rows, features = (
                dict(zip(ids, arrays[name], strict=True)) for name in ("descriptor", "feature")
            )
        return Descriptors(str(document["model"]), rows, features)
    except KeyError as error:
        hint = "write it anew: sceneq map RECORDING FOLDER"
        raise UserError(f"{folder}: no descriptors: {error.args[0]!s:.80} ({hint})", 2) from error
    except (OSError, ValueError) as error:
        raise UserError(f"{folder}: cannot be read: {error}", 2) from error


def describe(summary: Mapping[str, Any], out: Path) -> str:
    """Return one line about what was written."""
    return (
        f"{summary['instance_count']} instances, {summary['points']} points after frame "
        f"{summary['frame_seq']}, digest {summary['digest'][:16]} -> {out}"
    )
