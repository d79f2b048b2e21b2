"""What `sceneq map` and `sceneq export` leave on disk."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32, UInt8
from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.picture import draw_cloud, draw_labels, instance_colours, overview

LABELS_IN_PICTURE = 40
NAMED_FROM_P = 0.3
"""Less probable names are left out of the picture: their objects go by number."""


@dataclass(frozen=True, slots=True)
class SceneFiles:
    """A map ready to be written: points (N, 3) metres, colours, instance ids and their records.

    ``instances`` are the records that the scene lists (id, label, p, centre, boxes, views).
    """

    scene: str
    label_set: str
    replica: MapReplica
    instances: tuple[Mapping[str, Any], ...]

    def write(self, out: Path) -> dict[str, Any]:
        """Write all files into ``out`` and return the summary that is also in instances.json.

        Raises:
            OSError: the folder cannot be made or written.
        """
        out.mkdir(parents=True, exist_ok=True)
        points_world, rgb, instance_id = self.replica.cloud()
        np.savez_compressed(out / "instances.npz", points=points_world, instance_id=instance_id)
        summary = self._summary(points_world, instance_id)
        document = {**summary, "instances": list(self.instances)}
        (out / "instances.json").write_text(json.dumps(document, indent=1, ensure_ascii=False))
        _write_ply(out / "cloud.ply", points_world, instance_colours(instance_id, rgb))
        if len(points_world):
            self._write_picture(out / "instances.png", points_world, rgb, instance_id)
        return summary

    def _summary(self, points_world: Float32, instance_id: Int32) -> dict[str, Any]:
        coord = np.floor(points_world / self.replica.voxel_size_m).astype(np.int32)
        return {
            "scene": self.scene,
            "label_set": self.label_set,
            "frame_seq": self.replica.frame_seq,
            "voxel_size_m": self.replica.voxel_size_m,
            "up_world": [round(float(x), 4) for x in self.replica.up_world],
            "points": len(points_world),
            "instance_count": len(np.unique(instance_id[instance_id > 0])),
            "digest": map_digest(coord, points_world, instance_id),
        }

    def _write_picture(
        self, path: Path, points_world: Float32, rgb: UInt8, instance_id: Int32
    ) -> None:
        viewpoint = overview(points_world, self.replica.up_world)
        colours = instance_colours(instance_id, rgb)
        image = draw_cloud(viewpoint, points_world, colours, self.replica.voxel_size_m)
        cv2.imwrite(str(path), draw_labels(image, viewpoint, self._labels())[..., ::-1])

    def _labels(self) -> dict[str, Float64]:
        """The likeliest names at their places: a picture with all of them is not readable."""
        likeliest = sorted(self.instances, key=lambda record: (-record["p"], record["id"]))
        return {
            caption(record): np.asarray(record["centre"], np.float64)
            for record in likeliest[:LABELS_IN_PICTURE]
        }


def caption(record: Mapping[str, Any]) -> str:
    """Return id and name of an instance, the name only where it is probable."""
    named = record["p"] >= NAMED_FROM_P
    return f"{record['id']} {record['label']}" if named else str(record["id"])


def _write_ply(path: Path, points_world: Float32, rgb: UInt8) -> None:
    import open3d

    cloud = open3d.geometry.PointCloud()
    cloud.points = open3d.utility.Vector3dVector(points_world.astype(np.float64))
    cloud.colors = open3d.utility.Vector3dVector(rgb / 255.0)
    if not open3d.io.write_point_cloud(path, cloud):
        raise OSError(f"{path}: the point cloud could not be written")


def describe(summary: Mapping[str, Any], out: Path) -> str:
    """Return one line about what was written."""
    return (
        f"{summary['instance_count']} instances, {summary['points']} points after frame "
        f"{summary['frame_seq']}, digest {summary['digest'][:16]} -> {out}"
    )
