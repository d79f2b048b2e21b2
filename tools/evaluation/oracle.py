"""A scene whose instances are the true things, seen and described by the real parts of the graph.

As if segmentation and mapping made no mistake: what a pixel shows is what ``instance.png`` says.
Everything after that is what a robot runs: the keyframes, the choice of views, the crops, the
encoder, and the scene that questions are answered from.
"""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float64, Int32, UInt8
from sceneq_core.encoding.describe import Describer, Description
from sceneq_core.frame import Frame
from sceneq_core.ingest.ingestor import Ingested
from sceneq_core.ingest.source import Skipped
from sceneq_core.mapping.delta import Instance, MapDelta
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.scene import Scene, SceneSnapshot, ViewRef
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_core.views.place import STRIDE_PX, Places
from sceneq_core.views.selector import ViewSelector
from sceneq_core.views.view import View, ViewSet
from sceneq_nodes._ingesting import IngestSpecs, new_ingestor, open_source
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.rendered_truth import instance_image
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.true_things import THINGS_FILE, TrueThing, read_things
from sceneq_tools.progress import Advance

UP_WORLD = np.array([0.0, 0.0, 1.0])
"""Of every rendered recording."""

EPOCH = 1
NO_IDS = np.zeros(0, np.int32)


@dataclass(frozen=True, slots=True, eq=False)
class Oracle:
    """``snapshot`` of the true things that can be answered with, ``unseen`` ids of the others."""

    snapshot: SceneSnapshot
    unseen: tuple[int, ...]


class TruePlaces(Places):
    """Every thing is one place, and a label image says which place a pixel shows.

    Stuff has a place but no instance; what is not yet where it is in the end has none.
    """

    def __init__(self, folder: Path, things: Sequence[TrueThing]) -> None:
        super().__init__()
        self._folder = folder
        self._things = things
        self._highest = max((thing.id for thing in things), default=0)

    def instance_of_place(self, replica: MapReplica) -> Int32:
        """Return the thing at each place id - 1, int32 (P + 1,); 0 where it is no instance."""
        instance_id = np.zeros(self._highest + 1, np.int32)
        for thing in self._things:
            instance_id[thing.id - 1] = thing.id if is_candidate(thing) else 0
        return instance_id

    def render(self, frame: Frame, voxel_size_m: float) -> Int32:
        """Return the place of every second pixel, int32 (H/2, W/2), -1 = none."""
        shown = instance_image(self._folder, frame.seq)
        if shown.shape != frame.depth_m.shape:
            raise UserError(
                f"instance.png of frame {frame.seq}: {shown.shape}, not {frame.depth_m.shape}", 2
            )
        return self._places(frame.seq)[shown[::STRIDE_PX, ::STRIDE_PX]]

    def _places(self, seq: int) -> Int32:
        """Return the place of each id in an image of frame ``seq``."""
        place = np.full(np.iinfo(np.uint16).max + 1, -1, np.int32)
        for thing in self._things:
            if thing.since_frame is not None and seq >= thing.since_frame:
                place[thing.id] = thing.id - 1
        return place


def is_candidate(thing: TrueThing) -> bool:
    """Whether a thing can be answered with: no wall or floor, and there in the end."""
    return not thing.is_stuff and thing.since_frame is not None


def oracle(folder: Path, setup: Setup, advance: Advance) -> Oracle:
    """Return the true scene of a rendered recording; ``advance`` counts what is described.

    Raises:
        UserError: a file of the recording that is missing or malformed.
    """
    things = read_things(folder / THINGS_FILE)
    instances = true_instances(folder, [thing for thing in things if is_candidate(thing)])
    selector, last = _see(folder, setup, things, instances)
    scene = Scene(setup.router.labeller)
    scene.apply_map(Revision(EPOCH, 1, last.seq, last.stamp_ns), instances, UP_WORLD, full=True)
    view_sets = selector.view_sets()
    scene.apply_views(EPOCH, {one.instance_id: _refs(one) for one in view_sets})
    described = dict(_described(setup, selector, view_sets, advance))
    familiarity = {
        key: setup.router.labeller.familiarity(one.feature) for key, one in described.items()
    }
    descriptors = {key: one.descriptor for key, one in described.items()}
    scene.apply_descriptors(EPOCH, descriptors, NO_IDS, familiarity)
    scene.move_viewpoint(last.T_world_camera[:3, 3])
    snapshot = scene.snapshot()
    return Oracle(snapshot, tuple(one.instance_id for one in snapshot.waiting))


def true_views(
    folder: Path, setup: Setup, keep: Callable[[int], bool] = lambda number: True
) -> ViewSelector:
    """Return the views of every true thing, with their images; raises as ``oracle`` does.

    ``keep`` says of the number of a keyframe, from 0, whether it is looked at.
    """
    things = read_things(folder / THINGS_FILE)
    instances = true_instances(folder, [thing for thing in things if is_candidate(thing)])
    return _see(folder, setup, things, instances, keep)[0]


def _see(
    folder: Path,
    setup: Setup,
    things: Sequence[TrueThing],
    instances: Sequence[Instance],
    keep: Callable[[int], bool] = lambda number: True,
) -> tuple[ViewSelector, Ingested]:
    selector = ViewSelector(setup.views, TruePlaces(folder, things))
    selector.follow(_map(instances))
    return selector, _look(folder, setup, selector, keep)


def _look(
    folder: Path, setup: Setup, selector: ViewSelector, keep: Callable[[int], bool]
) -> Ingested:
    """Show the keyframes to ``selector``; return the last frame."""
    last, number = None, 0
    for last in ingested(folder, setup):
        if last.keyframe is not None:
            if keep(number):
                selector.see(last.keyframe)
                selector.changes()
            number += 1
    if last is None:
        raise UserError(f"{folder}: no frame can be used", 2)
    return last


def ingested(folder: Path, setup: Setup) -> Iterator[Ingested]:
    """Yield the frames of a recording as a graph would take them in; raises as ``oracle``."""
    specs = IngestSpecs({"kind": "folder", "path": str(folder)}, setup.keyframes)
    try:
        source = open_source(specs)
        ingestor = new_ingestor(source, specs)
    except ValueError as error:
        raise UserError(str(error), 2) from error
    for raw in source.frames():
        taken = raw if isinstance(raw, Skipped) else ingestor.ingest(raw)
        if isinstance(taken, Skipped):
            raise UserError(f"{taken.where}: {taken.reason}", 2)
        yield taken


def true_instances(folder: Path, things: Sequence[TrueThing]) -> list[Instance]:
    """Return the things with their true boxes."""
    records = json.loads((folder / THINGS_FILE).read_text())["instances"]
    boxes = {int(record["id"]): record["history"][-1]["box"] for record in records}
    return [_instance(thing.id, np.array(boxes[thing.id], np.float64)) for thing in things]


def _instance(thing_id: int, aabb_world: Float64) -> Instance:
    centre_world = aabb_world.mean(axis=0)
    T_world_box = np.eye(4)
    T_world_box[:3, 3] = centre_world
    return Instance(
        instance_id=thing_id,
        state="confirmed",
        merged_into=0,
        parent=0,
        superpoint_id=np.array([thing_id], np.int32),
        voxel_count=0,
        centre_world=centre_world,
        aabb_world=aabb_world,
        T_world_box=T_world_box,
        box_size_m=aabb_world[1] - aabb_world[0],
        first_seen_ns=0,
        last_seen_ns=0,
    )


def _map(instances: Sequence[Instance]) -> MapDelta:
    """Return a map of boxes without a voxel."""
    return MapDelta(
        full=True,
        frame_seq=0,
        stamp_ns=0,
        voxel_size_m=1.0,
        up_world=UP_WORLD,
        voxel_id=NO_IDS,
        voxel_coord=np.zeros((0, 3), np.int32),
        points_world=np.zeros((0, 3), np.float32),
        rgb=np.zeros((0, 3), np.uint8),
        superpoint_id=NO_IDS,
        removed_voxel_id=NO_IDS,
        instances=tuple(instances),
    )


def _refs(view_set: ViewSet) -> tuple[ViewRef, ...]:
    return tuple(ViewRef(view.seq, tuple(view.box_xyxy.tolist())) for view in view_set.views)


def _described(
    setup: Setup, selector: ViewSelector, view_sets: Sequence[ViewSet], advance: Advance
) -> Iterator[tuple[int, Description]]:
    describer = Describer(setup.encoder, setup.describe)

    def image(view: View) -> UInt8 | None:
        jpeg = selector.image(view.seq)
        return None if jpeg is None else rgb_from_jpeg(jpeg)

    for view_set in view_sets:
        description = describer.describe(view_set, image)
        advance()
        if description is not None:
            yield view_set.instance_id, description
