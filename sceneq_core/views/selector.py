"""The keyframes that show each instance best, kept up to date while the map grows."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sceneq_core.arrays import Bool, Int32
from sceneq_core.frame import Frame
from sceneq_core.mapping.delta import MapDelta
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.views.archive import ArchiveParams, ImageArchive
from sceneq_core.views.choice import Candidates, ChoiceParams, choose
from sceneq_core.views.keyframe import Keyframe, changed_blocks, make_keyframe
from sceneq_core.views.place import Places
from sceneq_core.views.sighting import (
    Sightings,
    columns_of,
    find_sightings,
    from_columns,
    make_view,
)
from sceneq_core.views.view import View, ViewSet

BOX_TOLERANCE_PX = 4.0
SIZE_TOLERANCE = 0.1
MOVED_TOLERANCE = 0.02
"""A view whose box and visible pixels changed less than this is left as it is: a crop is not the
better for it, and every change costs its readers an encoding. When hardly any pixel moved, the
view is not even made to compare."""


@dataclass(frozen=True, slots=True)
class ViewParams:
    """Parameters of the view selector."""

    choice: ChoiceParams = field(default_factory=ChoiceParams)
    archive: ArchiveParams = field(default_factory=ArchiveParams)


class ViewSelector:
    """Follows the map, looks at keyframes and names the top-k views of every instance.

    For each keyframe ``observe`` does: take over the map's change; note which voxel every pixel
    shows; recount the older keyframes in which a voxel changed its instance; choose again for the
    instances concerned. All but the first touch only what the change touched.
    """

    def __init__(self, params: ViewParams | None = None, places: Places | None = None) -> None:
        """Take what says which place a pixel shows; by default its voxel does."""
        self._params = params or ViewParams()
        self.replica = MapReplica()
        self.places = Places() if places is None else places
        self._instance_of_place: Int32 = np.zeros(1, np.int32)
        self._sightings: dict[int, Sightings] = {}
        self._view_sets: dict[int, ViewSet] = {}
        self._concerned: set[int] = set()
        self.archive = ImageArchive(self._params.archive)

    def observe(self, frame: Frame, delta: MapDelta) -> tuple[ViewSet, ...]:
        """Take over ``delta``, look at ``frame`` and return the view sets that changed.

        Raises:
            ValueError: a delta that contradicts itself; nothing has changed then.
        """
        self.follow(delta)
        self.see(frame)
        return self.changes()

    def follow(self, delta: MapDelta) -> None:
        """Take over a change of the map, or all of it; raise ``ValueError`` like ``observe``."""
        self.replica.apply(delta)
        moved_from = self.places.of(delta.moved_from_id)
        if delta.full:
            self.places.forget_voxels()
            self._concerned.update(self._view_sets)
        self.places.learn(delta.voxel_id, delta.voxel_coord)
        if len(moved_from):
            self._move(moved_from, self.places.of(delta.moved_to_id))
        self._concerned.update(instance.instance_id for instance in delta.instances)
        self._recount()

    def see(self, frame: Frame) -> None:
        """Add a keyframe; one with a known seq replaces it."""
        if frame.seq in self.archive:
            self.archive.remove(frame.seq)
            self._forget(frame.seq)
        for seq in self.archive.make_room():
            self._forget(seq)
        place = self.places.render(frame, self.replica.voxel_size_m)
        keyframe = make_keyframe(frame, place)
        self.archive.add(keyframe)
        sightings = find_sightings(keyframe, self._instance_of_place)
        self._sightings[frame.seq] = sightings
        self._concerned.update(sightings.visible_px)

    def changes(self) -> tuple[ViewSet, ...]:
        """Choose again for every instance concerned since the last call; return what changed."""
        chosen = {i: self._choose(i) for i in sorted(self._concerned)}
        images = self._instance_images(chosen)
        view_sets = [
            ViewSet(i, tuple(self._view(seq, i, images) for seq in seqs))
            for i, seqs in chosen.items()
        ]
        self._concerned.clear()
        return tuple(view_set for view_set in view_sets if self._take(view_set))

    def view_sets(self) -> tuple[ViewSet, ...]:
        """Return the view sets of all instances that have views, by instance id."""
        return tuple(self._view_sets[i] for i in sorted(self._view_sets))

    def image(self, seq: int) -> bytes | None:
        """Return the JPEG of a keyframe, ``None`` when it is gone; safe from any thread."""
        return self.archive.jpeg(seq)

    def parts(self) -> dict[str, Any]:
        """Return what is kept beside the keyframes, the view sets, the places and the map."""
        return {
            "sightings": columns_of(self._sightings),
            "concerned": self._concerned,
            "archive": self.archive.parts(),
        }

    def resume(
        self,
        keyframes: Mapping[int, Keyframe],
        place_coords: Int32,
        replica: MapReplica,
        view_sets: Iterable[ViewSet],
        parts: Mapping[str, Any],
    ) -> None:
        """Become the selector whose ``parts`` these are, with its map as of then.

        A keyframe that is not among ``keyframes`` any more is let go of, with what was seen in it;
        for an instance without a view set it is chosen again.
        """
        self.places.extend(place_coords)
        self.replica = replica
        alive = np.flatnonzero(replica.alive).astype(np.int32)
        self.places.learn(alive, replica.voxel_coord[alive])
        self._instance_of_place = self.places.instance_of_place(replica)
        self._sightings = from_columns(parts["sightings"])
        self._view_sets = {view_set.instance_id: view_set for view_set in view_sets}
        self._concerned = parts["concerned"] | (replica.instances.keys() - self._view_sets.keys())
        self.archive.resume(keyframes, parts["archive"])
        for seq in [seq for seq in self._sightings if seq not in self.archive]:
            self._forget(seq)

    def _recount(self) -> None:
        """Count again where keyframes show places that changed their instance."""
        before, now = self._instance_of_place, self.places.instance_of_place(self.replica)
        self._instance_of_place = now
        changed = _differs(before, now)
        blocks = changed_blocks(changed)
        for keyframe in self.archive:
            touched = keyframe.touched(changed, blocks)
            if len(touched):
                sightings = self._sightings[keyframe.seq]
                self._concerned |= sightings.update(keyframe, touched, before, now)

    def _move(self, from_place: Int32, to_place: Int32) -> None:
        """Let keyframes show surfaces where they are since a correction of poses."""
        place_now = self.places.moves(from_place, to_place)
        self._instance_of_place = self.places.instance_of_place(self.replica)
        for keyframe in tuple(self.archive):
            moved = keyframe.moved(place_now)
            self.archive.add(moved)
            sightings = find_sightings(moved, self._instance_of_place)
            self._concerned.update(self._sightings[moved.seq].visible_px, sightings.visible_px)
            self._sightings[moved.seq] = sightings

    def _forget(self, seq: int) -> None:
        """Drop what was seen in a keyframe that the archive let go of."""
        del self._sightings[seq]
        self._concerned.update(i for i, views in self._view_sets.items() if _shows(views, seq))

    def _choose(self, instance_id: int) -> tuple[int, ...]:
        """Return the seqs of the best keyframes of an instance, best first."""
        instance = self.replica.instances.get(instance_id)
        shown = [k for k in self.archive if instance_id in self._sightings[k.seq].visible_px]
        if instance is None or not shown:
            return ()
        sightings = [self._sightings[keyframe.seq] for keyframe in shown]
        candidates = Candidates(
            visible_px=np.array([of.visible_px[instance_id] for of in sightings]),
            cut=np.array([instance_id in of.cut for of in sightings]),
            camera_world=np.array([keyframe.camera_world for keyframe in shown]),
        )
        rows = choose(candidates, instance.centre_world, self._params.choice)
        return tuple(shown[row].seq for row in rows)

    def _instance_images(self, chosen: dict[int, tuple[int, ...]]) -> dict[int, Int32]:
        """Return the instance image of each keyframe in which a view has to be made."""
        new = {seq for i, seqs in chosen.items() for seq in seqs if not self._holds(seq, i)}
        return {seq: self._instance_of_place.take(self.archive[seq].place) for seq in new}

    def _view(self, seq: int, instance_id: int, images: dict[int, Int32]) -> View:
        """Return the view of an instance in a keyframe; the present one if it still holds."""
        present = self._present(seq, instance_id)
        if present and self._holds(seq, instance_id):
            return present
        self._sightings[seq].moved_px.pop(instance_id, None)
        view = make_view(self.archive[seq], images[seq], instance_id)
        return present if present and _alike(present, view) else view

    def _holds(self, seq: int, instance_id: int) -> bool:
        """Tell whether there is a view of an instance in a keyframe and hardly a pixel moved."""
        present = self._present(seq, instance_id)
        moved_px = self._sightings[seq].moved_px.get(instance_id, 0)
        return present is not None and moved_px <= MOVED_TOLERANCE * present.visible_px

    def _present(self, seq: int, instance_id: int) -> View | None:
        view_set = self._view_sets.get(instance_id)
        views = view_set.views if view_set else ()
        return next((view for view in views if view.seq == seq), None)

    def _take(self, view_set: ViewSet) -> bool:
        """Make ``view_set`` the present one; tell whether that changes anything."""
        old = self._view_sets.pop(view_set.instance_id, ViewSet(view_set.instance_id, ()))
        if view_set.views:
            self._view_sets[view_set.instance_id] = view_set
        self.archive.refer(view_set.instance_id, tuple(view.seq for view in view_set.views))
        return [id(view) for view in old.views] != [id(view) for view in view_set.views]


def _differs(before: Int32, now: Int32) -> Bool:
    """Tell which places changed their instance; both arrays end with the 0 of "no place"."""
    changed = np.zeros(len(now), np.bool_)
    known = len(before) - 1
    changed[:known] = before[:known] != now[:known]
    return changed


def _shows(view_set: ViewSet, seq: int) -> bool:
    return any(view.seq == seq for view in view_set.views)


def _alike(a: View, b: View) -> bool:
    """Tell whether two views in one keyframe give the same crop, so that nobody need hear of it."""
    if a.stamp_ns != b.stamp_ns or np.abs(a.box_xyxy - b.box_xyxy).max() > BOX_TOLERANCE_PX:
        return False
    return abs(a.visible_px - b.visible_px) <= SIZE_TOLERANCE * a.visible_px
