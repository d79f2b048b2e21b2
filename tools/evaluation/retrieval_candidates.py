"""What questions are answered with: the true things, or the instances of a map."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.evaluation.mask_iou import mask_iou
from sceneq_core.ingest.source import Skipped
from sceneq_core.mapping.delta import CONFIRMED, OBJECT, Instance
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.scene import Scene, SceneSnapshot, ViewRef
from sceneq_nodes._ingesting import IngestSpecs, open_source
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.oracle import EPOCH, NO_IDS, Oracle
from sceneq_tools.evaluation.predictions import REACH_M, nearest_ids
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.truth import Truth
from sceneq_tools.scene_files import read_descriptors, read_scene

Matches = Mapping[int, frozenset[int]]
"""Id of a true thing -> ids of the candidates that are it."""

EXACT = "true mask"


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """A snapshot to ask about.

    ``matches``: for every rule of what counts as a hit, which candidates are which true thing.
    """

    name: str
    snapshot: SceneSnapshot
    matches: Mapping[str, Matches]


def true_candidates(oracle: Oracle) -> Candidates:
    """Return the true things as candidates: each is itself."""
    ids = [one.instance_id for one in oracle.snapshot.instances]
    itself = {one: frozenset([one]) for one in ids}
    return Candidates("true instances", oracle.snapshot, {EXACT: itself})


def map_candidates(
    folder: Path, recording: Path, truth: Truth, setup: Setup, thresholds: Sequence[float]
) -> Candidates:
    """Return the instances of a folder that ``sceneq map`` wrote, seen from the recording's end.

    Raises:
        UserError: the folder is not complete, or its descriptors are of another encoder.
    """
    cloud, document = read_scene(folder)
    snapshot = _snapshot(folder, document, setup, _last_position(recording))
    assert truth.points_world is not None  # of a rendered recording they are known
    ids = nearest_ids(
        cloud.points_world, cloud.instance_id.astype(np.int64), truth.points_world, REACH_M
    )
    iou, true_ids, map_ids = mask_iou(truth.number, ids)
    matches = {}
    for limit in thresholds:
        same = iou >= limit
        rows = zip(true_ids.tolist(), same, strict=True)
        matches[f"IoU >= {limit:g}"] = {i: frozenset(map_ids[row].tolist()) for i, row in rows}
    return Candidates("map", snapshot, matches)


def _snapshot(
    folder: Path, document: Mapping[str, Any], setup: Setup, viewpoint_world: Float64
) -> SceneSnapshot:
    described = read_descriptors(folder)
    model = setup.encoder.model_id
    if described.model != model:
        was = f"described by the encoder {described.model!r}, the graph has {model!r}"
        raise UserError(f"{folder}: {was}", 2)
    labeller = setup.router.labeller
    scene, records = Scene(labeller), document["instances"]
    familiarity = {key: labeller.familiarity(one) for key, one in described.features.items()}
    up_world = np.asarray(document["up_world"], np.float64)
    revision = Revision(EPOCH, 1, document["frame_seq"], 0)
    scene.apply_map(revision, map(_instance, records), up_world, full=True)
    scene.apply_views(EPOCH, {int(record["id"]): _views(record) for record in records})
    scene.apply_descriptors(EPOCH, described.rows, NO_IDS, familiarity)
    scene.move_viewpoint(viewpoint_world)
    return scene.snapshot()


def _instance(record: Mapping[str, Any]) -> Instance:
    """Return the geometry in a record of the scene's list."""
    oriented, aligned = record["box_oriented"], record["box_aabb"]
    T_world_box = np.eye(4)
    T_world_box[:3, :3] = oriented["rotation"]
    T_world_box[:3, 3] = oriented["centre"]
    return Instance(
        instance_id=int(record["id"]),
        state=record.get("state", CONFIRMED),
        merged_into=0,
        parent=0,
        superpoint_id=NO_IDS,
        voxel_count=0,
        centre_world=np.array(record["centre"], np.float64),
        aabb_world=np.array([aligned["min"], aligned["max"]], np.float64),
        T_world_box=T_world_box,
        box_size_m=np.array(oriented["size"], np.float64),
        first_seen_ns=record["first_seen_ns"],
        last_seen_ns=record["last_seen_ns"],
        role=record.get("role", OBJECT),
        supported_by=record.get("supported_by") or 0,
        inside=record.get("inside") or 0,
        neighbour_id=np.array(record.get("neighbours", ()), np.int32),
    )


def _views(record: Mapping[str, Any]) -> tuple[ViewRef, ...]:
    return tuple(ViewRef(view["seq"], tuple(view["box_xyxy"])) for view in record["views"])


def _last_position(recording: Path) -> Float64:
    """Return where the camera is at the end of a recording, (3,) metres."""
    source = open_source(IngestSpecs({"kind": "folder", "path": str(recording)}))
    poses = [raw.T_world_camera for raw in source.frames() if not isinstance(raw, Skipped)]
    given = [pose for pose in poses if pose is not None]
    if not given:
        raise UserError(f"{recording}: no frame has a pose", 2)
    return given[-1][:3, 3]
