"""The scene that is exported, wherever it comes from."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64, Int64, UInt8
from sceneq_core.picture import instance_colours
from sceneq_core.picture.scene import Cloud
from sceneq_tools.scene_files import SceneFiles, read_scene

Record = Mapping[str, Any]
Picture = Callable[[str], bytes | None]
"""Key of a view to the JPEG of its keyframe; ``None`` when it is gone."""


@dataclass(frozen=True, slots=True)
class ExportedScene:
    """Points with their instances and what is known of these; metres, world frame.

    ``document`` is that of instances.json; without ``picture`` there are no evidence images;
    ``files`` are there when the map itself is at hand.
    """

    cloud: Cloud
    document: Mapping[str, Any]
    picture: Picture | None = None
    files: SceneFiles | None = None

    @property
    def name(self) -> str:
        """The id of the scene."""
        return str(self.document["scene"])

    @property
    def records(self) -> tuple[Record, ...]:
        """Every instance, by id."""
        return tuple(sorted(self.document["instances"], key=lambda record: int(record["id"])))

    def rows(self) -> Iterator[tuple[Record, Int64]]:
        """Yield every instance that has points with the numbers of its points, int64 (M,)."""
        order = np.argsort(self.cloud.instance_id, kind="stable")
        owner = self.cloud.instance_id[order]
        for record in self.records:
            first, last = np.searchsorted(owner, (record["id"], record["id"] + 1))
            if first < last:
                yield record, order[first:last]

    def colours(self) -> UInt8:
        """Return the colour of every point's instance, uint8 (N, 3)."""
        return instance_colours(self.cloud.instance_id, self.cloud.rgb)


def from_folder(folder: Path) -> ExportedScene:
    """Return the scene that `sceneq map` or `sceneq export` wrote; raise ``UserError`` if none."""
    cloud, document = read_scene(folder)
    return ExportedScene(cloud, document)


def from_files(files: SceneFiles, picture: Picture) -> ExportedScene:
    """Return the scene of a running graph."""
    cloud = files.cloud()
    return ExportedScene(cloud, files.document(cloud), picture, files)


def node_name(record: Record) -> str:
    """Return a name that people can read and that no other instance has, such as ``mug 12``."""
    return f"{record.get('label') or 'thing'} {record['id']}"


def T_world_box(record: Record) -> tuple[Float64, Float64]:
    """Return the pose (4, 4) of an instance's oriented box and its edges (3,) in metres."""
    box = record["box_oriented"]
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = box["rotation"], box["centre"]
    return pose, np.asarray(box["size"], np.float64)
