"""What questions are answered from: an immutable picture of the scene, and how it is kept new."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from types import MappingProxyType

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32
from sceneq_core.encoding.looks import FAMILIAR
from sceneq_core.mapping.delta import OBJECT, REMOVED, TENTATIVE, Instance
from sceneq_core.routing.columns import Columns, columns_of, joined
from sceneq_core.routing.described import Described, Matrices, describe, no_matrices, stacked
from sceneq_core.routing.labels import Label, Labeller
from sceneq_core.routing.measured import Measured
from sceneq_core.routing.names import NO_NAMES, Names
from sceneq_core.routing.past import Gone, Past
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.row_blocks import RowBlocks

Box = tuple[float, float, float, float]

PAGE = 256
"""So many neighbouring ids are made anew together: what a change costs does not depend on the size
of the map, and a question still meets few, large blocks."""
NO_COLUMNS = columns_of((), no_matrices(1))


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
    ``names`` are those that were taught, ``past`` what is gone from the map.
    """

    revision: Revision
    instances: tuple[SceneInstance, ...]
    columns: Columns
    descriptors: RowBlocks
    label_scores: RowBlocks
    waiting: tuple[Instance, ...]
    up_world: Float64
    viewpoint_world: Float64
    names: Names = NO_NAMES
    past: tuple[Gone, ...] = ()

    def __len__(self) -> int:
        return len(self.instances)

    @property
    def instance_count(self) -> int:
        """How many instances the map has."""
        return len(self.instances) + len(self.waiting)

    def find(self, instance_id: int) -> int | None:
        """Return the row of an instance, or ``None``."""
        row = int(np.searchsorted(self.columns.instance_id, instance_id))
        found = row < len(self) and int(self.columns.instance_id[row]) == instance_id
        return row if found else None


@dataclass(frozen=True, slots=True)
class _Page:
    """The part of a snapshot with the ids of one page."""

    instances: tuple[SceneInstance, ...]
    columns: Columns
    matrices: Matrices
    waiting: tuple[Instance, ...]


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
        self._dim = labeller.text_vectors.shape[1]
        self._revision = Revision()
        self._up_world = np.array([0.0, 0.0, 1.0])
        self._viewpoint_world = np.zeros(3)
        self._geometry: dict[int, Instance] = {}
        self._views: dict[int, tuple[ViewRef, ...]] = {}
        self._views_epoch = 0
        self._described: dict[int, Described] = {}
        self._described_epoch = 0
        self._pages: dict[int, _Page] = {}
        self._stale: set[int] = set()
        self._past = Past()
        self._measured = Measured(labeller)

    def apply_map(
        self, revision: Revision, instances: Iterable[Instance], up_world: Float64, *, full: bool
    ) -> None:
        """Take over changed instances; all of them when ``full``."""
        if full or revision.epoch != self._revision.epoch:
            self._forget_pages()
        if revision.epoch != self._revision.epoch:
            self._past.clear()
        if full:
            self._geometry = {}
        changed = tuple(instances)
        for instance in changed:
            self._stale.add(instance.instance_id // PAGE)
            if instance.state != REMOVED:
                self._geometry[instance.instance_id] = instance
                self._past.forget(instance.instance_id)
            else:
                self._leave(instance, revision.stamp_ns)
        self._revision = revision.after(self._revision, changed)
        self._up_world = _unit(up_world, self._up_world)
        there = [one for one in changed if one.state != REMOVED]
        if self._measured.see(there, self._up_world, full=full):
            self._forget_pages()

    def _leave(self, removed: Instance, stamp_ns: int) -> None:
        """Take an instance out of the map; what was only merged into another is not gone."""
        key = removed.instance_id
        if key in self._geometry and not removed.merged_into and self._answerable(key):
            gone = Gone(self._geometry[key], self._views[key], self._measured_of(key))
            self._past.keep(gone, stamp_ns)
        self._geometry.pop(key, None)
        self._measured.forget(key)

    def apply_views(self, map_epoch: int, views: Mapping[int, tuple[ViewRef, ...]]) -> None:
        """Take over changed views by instance id, computed against the map of ``map_epoch``."""
        if map_epoch != self._views_epoch:
            self._views = {}
            self._forget_pages()
        self._views_epoch = map_epoch
        for instance_id, seen in views.items():
            self._stale.add(instance_id // PAGE)
            if seen:
                self._views[instance_id] = seen
            else:
                self._views.pop(instance_id, None)

    def apply_descriptors(
        self,
        map_epoch: int,
        descriptors: Mapping[int, Float32],
        removed: Int32,
        familiarity: Mapping[int, float] = MappingProxyType({}),
    ) -> None:
        """Take over changed descriptors by id in the map of ``map_epoch``; labels follow for these.

        ``familiarity`` of these, where it is known; the others look like what was taught.

        Raises:
            ValueError: a descriptor whose length is not the label texts' or that is not finite.
        """
        described = {}
        for instance_id, descriptor in descriptors.items():
            if not self.accepts(descriptor):
                raise ValueError(
                    f"descriptor of instance {instance_id}: expected {self._dim} finite numbers, "
                    f"got shape {descriptor.shape}"
                )
            familiar = familiarity.get(instance_id, FAMILIAR)
            described[instance_id] = describe(descriptor, self._labeller, familiar)
        if map_epoch != self._described_epoch:
            self._described = {}
            self._forget_pages()
        self._described_epoch = map_epoch
        for instance_id in removed.tolist():
            self._described.pop(instance_id, None)
        self._described.update(described)
        self._stale.update(key // PAGE for key in (*removed.tolist(), *described))

    def take_over(self, other: "Scene") -> None:
        """Know the map and the views that ``other`` knows; descriptors are of its encoder only."""
        self._revision = other._revision
        self._up_world = other._up_world
        self._viewpoint_world = other._viewpoint_world
        self._geometry = dict(other._geometry)
        self._views = dict(other._views)
        self._views_epoch = other._views_epoch
        self._measured.see(self._geometry.values(), self._up_world, full=True)
        self._forget_pages()

    def accepts(self, descriptor: Float32) -> bool:
        """Return whether ``descriptor`` is finite and as long as the label texts' vectors."""
        return descriptor.shape == (self._dim,) and bool(np.isfinite(descriptor).all())

    def move_viewpoint(self, position_world: Float64) -> None:
        """Remember where the camera is now, (3,) metres."""
        self._viewpoint_world = np.array(position_world, np.float64)

    def snapshot(self) -> SceneSnapshot:
        """Return the scene as it is now; what has not changed is shared with earlier snapshots."""
        self._renew_pages()
        pages = [self._pages[number] for number in sorted(self._pages)]
        labels = len(self._labeller.label_set)
        return SceneSnapshot(
            revision=self._revision,
            instances=tuple(chain.from_iterable(page.instances for page in pages)),
            columns=joined([NO_COLUMNS, *(page.columns for page in pages)]),
            descriptors=RowBlocks([page.matrices.descriptors for page in pages], self._dim),
            label_scores=RowBlocks([page.matrices.label_scores for page in pages], labels),
            waiting=tuple(chain.from_iterable(page.waiting for page in pages)),
            up_world=self._up_world,
            viewpoint_world=self._viewpoint_world,
            past=self._past.all(),
        )

    def _forget_pages(self) -> None:
        self._pages = {}
        self._stale = {instance_id // PAGE for instance_id in self._geometry}

    def _renew_pages(self) -> None:
        for number in self._stale:
            ids = range(number * PAGE, (number + 1) * PAGE)
            here = [instance_id for instance_id in ids if instance_id in self._geometry]
            if here:
                self._pages[number] = self._page(here, self._pages.get(number))
            else:
                self._pages.pop(number, None)
        self._stale = set()

    def _page(self, here: Sequence[int], before: _Page | None) -> _Page:
        """Return the page of the instances ``here``, in place of the one ``before``."""
        ids = [key for key in here if self._answerable(key)]
        geometry, known = [self._geometry[key] for key in ids], frozenset(ids)
        matrices = self._matrices(ids, before.matrices if before else None)
        return _Page(
            instances=tuple(
                SceneInstance(one, self._views[key], self._label(key))
                for key, one in zip(ids, geometry, strict=True)
            ),
            columns=columns_of(geometry, matrices),
            matrices=matrices,
            waiting=tuple(self._geometry[key] for key in here if key not in known),
        )

    def _matrices(self, ids: Sequence[int], before: Matrices | None) -> Matrices:
        """Stack what is known of ``ids``; most changes of a map change nothing here."""
        described = tuple(self._measured_of(key) for key in ids)
        if before is not None and before.described == described:
            return before
        return stacked(described, self._labeller)

    def _measured_of(self, key: int) -> Described:
        return self._measured.of(self._described[key], self._geometry[key])

    def _answerable(self, instance_id: int) -> bool:
        if self._geometry[instance_id].state == TENTATIVE:
            return False
        same_map = self._views_epoch == self._described_epoch == self._revision.epoch
        return same_map and bool(self._views.get(instance_id)) and instance_id in self._described

    def _label(self, instance_id: int) -> Label:
        """Return what an instance is called; what is part of the building is called by its role."""
        label, role = self._measured_of(instance_id).label, self._geometry[instance_id].role
        return label if role == OBJECT else Label(role, self._labeller.ceiling, label.cosine)


def _unit(vector: Float64, otherwise: Float64) -> Float64:
    """A map that does not know up yet sends zeros."""
    length = float(np.linalg.norm(vector))
    return vector / length if np.isfinite(length) and length > 0 else otherwise
