"""What questions are answered from: an immutable picture of the scene, and how it is kept new."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32
from sceneq_core.mapping.delta import OBJECT, REMOVED, TENTATIVE, Instance
from sceneq_core.routing.labels import Label, Labeller

Box = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Revision:
    """Which state of the map this is: ``frame_seq`` and ``stamp_ns`` of its newest keyframe."""

    epoch: int = 0
    seq: int = 0
    frame_seq: int = -1
    stamp_ns: int = 0


@dataclass(frozen=True, slots=True)
class ViewRef:
    """Evidence: a keyframe that shows an instance, ``box_xyxy`` in its pixels."""

    seq: int
    box_xyxy: Box


@dataclass(frozen=True, slots=True)
class SceneInstance:
    """An instance with everything an answer says about it; views are most visible first."""

    geometry: Instance
    views: tuple[ViewRef, ...]
    label: Label

    @property
    def instance_id(self) -> int:
        """The id the map gave it."""
        return self.geometry.instance_id


@dataclass(frozen=True, slots=True)
class SceneSnapshot:
    """The instances that can be answered with, sorted by id, and their matrices.

    ``descriptors`` float32 (N, D) unit rows; ``label_scores`` float32 (N, C) cosines with the
    label set; ``waiting`` are the map's other instances, which are tentative or have no descriptor
    or no view yet.
    ``viewpoint_world`` (3,) metres is the newest camera position, ``up_world`` (3,) unit.
    """

    revision: Revision
    instances: tuple[SceneInstance, ...]
    descriptors: Float32
    label_scores: Float32
    waiting: tuple[Instance, ...]
    up_world: Float64
    viewpoint_world: Float64

    def __len__(self) -> int:
        return len(self.instances)

    @property
    def instance_count(self) -> int:
        """How many instances the map has."""
        return len(self.instances) + len(self.waiting)

    def find(self, instance_id: int) -> int | None:
        """Return the row of an instance, or ``None``."""
        ids = [instance.instance_id for instance in self.instances]
        return ids.index(instance_id) if instance_id in ids else None


@dataclass(frozen=True, slots=True)
class _Described:
    """A descriptor (D,) with what follows from it, worked out once."""

    descriptor: Float32
    label_scores: Float32
    label: Label


class Scene:
    """Follows map, views and descriptors; every ``snapshot`` is independent of later changes.

    An instance enters the snapshot when it has geometry, a descriptor and at least one view of
    the same map epoch: no answer without evidence, and no descriptor of a map that is gone. One
    that is tentative has to wait; one that is stale is answered with, and its state says so.

    Views and descriptors that are not mentioned stay, also when their writer starts again: it has
    yet to see the instances again, and what it told before is still true of the same map.
    """

    def __init__(self, labeller: Labeller) -> None:
        self._labeller = labeller
        self._revision = Revision()
        self._up_world = np.array([0.0, 0.0, 1.0])
        self._viewpoint_world = np.zeros(3)
        self._geometry: dict[int, Instance] = {}
        self._views: dict[int, tuple[ViewRef, ...]] = {}
        self._views_epoch = 0
        self._described: dict[int, _Described] = {}
        self._described_epoch = 0

    def apply_map(
        self, revision: Revision, instances: Iterable[Instance], up_world: Float64, *, full: bool
    ) -> None:
        """Take over changed instances; all of them when ``full``."""
        if full:
            self._geometry = {}
        for instance in instances:
            if instance.state != REMOVED:
                self._geometry[instance.instance_id] = instance
            else:
                self._geometry.pop(instance.instance_id, None)
        self._revision = revision
        self._up_world = _unit(up_world, self._up_world)

    def apply_views(self, map_epoch: int, views: Mapping[int, tuple[ViewRef, ...]]) -> None:
        """Take over changed views by instance id, computed against the map of ``map_epoch``."""
        known = self._views if map_epoch == self._views_epoch else {}
        self._views = {key: seen for key, seen in {**known, **views}.items() if seen}
        self._views_epoch = map_epoch

    def apply_descriptors(
        self, map_epoch: int, descriptors: Mapping[int, Float32], removed: Int32
    ) -> None:
        """Take over changed descriptors by id in the map of ``map_epoch``; labels follow for these.

        Raises:
            ValueError: a descriptor whose length is not the label texts' or that is not finite.
        """
        described = {key: self._describe(key, value) for key, value in descriptors.items()}
        if map_epoch != self._described_epoch:
            self._described = {}
        self._described_epoch = map_epoch
        for instance_id in removed.tolist():
            self._described.pop(instance_id, None)
        self._described.update(described)

    def take_over(self, other: "Scene") -> None:
        """Know the map and the views that ``other`` knows; descriptors are of its encoder only."""
        self._revision = other._revision
        self._up_world = other._up_world
        self._viewpoint_world = other._viewpoint_world
        self._geometry = dict(other._geometry)
        self._views = dict(other._views)
        self._views_epoch = other._views_epoch

    def accepts(self, descriptor: Float32) -> bool:
        """Return whether ``descriptor`` is finite and as long as the label texts' vectors."""
        dim = self._labeller.text_vectors.shape[1]
        return descriptor.shape == (dim,) and bool(np.isfinite(descriptor).all())

    def move_viewpoint(self, position_world: Float64) -> None:
        """Remember where the camera is now, (3,) metres."""
        self._viewpoint_world = np.array(position_world, np.float64)

    def snapshot(self) -> SceneSnapshot:
        """Return the scene as it is now."""
        ids = [key for key in sorted(self._geometry) if self._answerable(key)]
        rows = [self._described[key] for key in ids]
        dim, labels = self._labeller.text_vectors.shape[1], len(self._labeller.label_set)
        return SceneSnapshot(
            revision=self._revision,
            instances=tuple(
                SceneInstance(self._geometry[key], self._views[key], self._label(key))
                for key, row in zip(ids, rows, strict=True)
            ),
            descriptors=_rows([row.descriptor for row in rows], dim),
            label_scores=_rows([row.label_scores for row in rows], labels),
            waiting=tuple(self._geometry[key] for key in sorted(self._geometry.keys() - set(ids))),
            up_world=self._up_world,
            viewpoint_world=self._viewpoint_world,
        )

    def _answerable(self, instance_id: int) -> bool:
        if self._geometry[instance_id].state == TENTATIVE:
            return False
        same_map = self._views_epoch == self._described_epoch == self._revision.epoch
        return same_map and bool(self._views.get(instance_id)) and instance_id in self._described

    def _label(self, instance_id: int) -> Label:
        """Return what an instance is called; what is part of the building is called by its role."""
        label, role = self._described[instance_id].label, self._geometry[instance_id].role
        return label if role == OBJECT else Label(role, self._labeller.ceiling, label.cosine)

    def _describe(self, instance_id: int, descriptor: Float32) -> _Described:
        if not self.accepts(descriptor):
            dim = self._labeller.text_vectors.shape[1]
            raise ValueError(
                f"descriptor of instance {instance_id}: expected {dim} finite numbers, "
                f"got shape {descriptor.shape}"
            )
        scores = self._labeller.scores(descriptor[None])[0]
        return _Described(descriptor, scores, self._labeller.best_of_scores(scores)[0])


def _rows(rows: list[Float32], width: int) -> Float32:
    return np.stack(rows) if rows else np.zeros((0, width), np.float32)


def _unit(vector: Float64, otherwise: Float64) -> Float64:
    """A map that does not know up yet sends zeros."""
    length = float(np.linalg.norm(vector))
    return vector / length if np.isfinite(length) and length > 0 else otherwise
