"""A recording of a room that changes, mapped once and judged at every cut."""

from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.evaluation.scene_changes import Fate, Moment, fates
from sceneq_nodes._bus import Context
from sceneq_tools.batch import Batch, Stage
from sceneq_tools.evaluation.change_history import read_history
from sceneq_tools.evaluation.map_watcher import MapWatcher
from sceneq_tools.evaluation.predictions import REACH_M, nearest_ids
from sceneq_tools.evaluation.rendered_truth import read_rendered
from sceneq_tools.evaluation.truth import Truth
from sceneq_tools.graph_plan import Plan

MAPPERS = ("ingest", "segmentation", "mapping", "views")
WATCHER = "watcher"


@dataclass(frozen=True, slots=True)
class CutReport:
    """What became of everything between the two moments around a cut."""

    frame: int
    fates: tuple[Fate, ...]

    @property
    def edits(self) -> list[Fate]:
        """Return the things that were moved, brought or taken."""
        return [fate for fate in self.fates if fate.kind != "stayed"]

    @property
    def stayed(self) -> list[Fate]:
        """Return the things that stayed and could get lost."""
        return [fate for fate in self.fates if fate.kind == "stayed" and fate.is_judged]

    def as_dict(self, names: dict[int, str]) -> dict[str, Any]:
        """Return everything in values that JSON knows."""
        judged = [fate for fate in self.fates if fate.is_judged]
        return {
            "frame": self.frame,
            "things": [
                {**asdict(f), "name": names[f.thing], "known": f.is_known, "kept_id": f.kept_id}
                for f in judged
            ],
        }


class Changes:
    """Maps a recording once (``stages``), then judges the map at every cut (``reports``)."""

    def __init__(self, folder: Path, plan: Plan) -> None:
        self._folder = folder
        self.history = read_history(folder)
        nodes = tuple(node for node in plan.nodes if node.node_kind in MAPPERS)
        context = Context(WATCHER, plan.scene, plan.robot, plan.sensor)
        self._watcher = MapWatcher(self.history.cuts, context)
        self._batch = Batch(replace(plan, nodes=nodes), {WATCHER: self._watcher})

    def stages(self) -> Iterator[Stage]:
        """Yield what there is to do, as ``Batch`` does."""
        yield from self._batch.stages()

    def close(self) -> None:
        """Close the nodes."""
        self._batch.close()

    def reports(self) -> list[CutReport]:
        """Return what became of the things at every cut; the recording has been played."""
        self._watcher.look()
        ends = (*self.history.cuts[1:], None)
        return [
            CutReport(cut, self._fates(place, cut, end))
            for place, (cut, end) in enumerate(zip(self.history.cuts, ends, strict=True))
        ]

    def _fates(self, place: int, cut: int, end: int | None) -> tuple[Fate, ...]:
        truths = (
            read_rendered(self._folder, before_frame=cut),
            read_rendered(self._folder, before_frame=end),
        )
        first, second = self._watcher.seen[place : place + 2]
        was_world, is_world = (_points(truth) for truth in truths)
        before = Moment(truths[0].number, first.at(was_world))
        after = Moment(truths[1].number, second.at(is_world))
        everywhere = np.ones(len(is_world), np.int64)
        vacated = nearest_ids(is_world, everywhere, was_world, REACH_M) == 0
        changed = self.history.changed[place]
        return fates(before, after, second.at(was_world), vacated, changed)


def _points(truth: Truth) -> Float32:
    assert truth.points_world is not None  # of a rendered recording
    return truth.points_world
