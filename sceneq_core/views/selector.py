"""The keyframes that show each instance best, kept up to date while the map grows."""

from dataclasses import dataclass, field

import numpy as np

from sceneq_core.arrays import Bool, Int32
from sceneq_core.frame import Frame
from sceneq_core.mapping.delta import MapDelta
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.views.archive import ArchiveParams, ImageArchive
from sceneq_core.views.choice import Candidates, ChoiceParams, choose
from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_core.views.place import Places
from sceneq_core.views.sighting import Keyframe, Sighting, find_sightings, make_view
from sceneq_core.views.view import View, ViewSet


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

    def __init__(self, params: ViewParams | None = None) -> None:
        self._params = params or ViewParams()
        self._replica = MapReplica()
        self._places = Places()
        self._instance_of_place: Int32 = np.zeros(1, np.int32)
        self._sightings: dict[int, dict[int, Sighting]] = {}
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
        self._replica.apply(delta)
        if delta.full:
            self._places.forget_voxels()
            self._concerned.update(self._view_sets)
        self._places.learn(delta.voxel_id, delta.voxel_coord)
        self._concerned.update(instance.instance_id for instance in delta.instances)
        self._recount(self._places.instance_of_place(self._replica))

    def see(self, frame: Frame) -> None:
        """Add a keyframe; one with a known seq replaces it."""
        self._concerned.update(self._forget(self.archive.trim()))
        if frame.seq in self.archive:
            self.archive.remove(frame.seq)
            self._concerned.update(self._forget((frame.seq,)))
        keyframe = Keyframe(
            seq=frame.seq,
            stamp_ns=frame.stamp_ns,
            jpeg=jpeg_from_rgb(frame.rgb),
            size=(frame.rgb.shape[0], frame.rgb.shape[1]),
            camera_world=frame.T_world_camera[:3, 3].copy(),
            places=self._places.render(frame, self._replica.voxel_size_m),
        )
        self.archive.add(keyframe)
        self._look(keyframe)

    def changes(self) -> tuple[ViewSet, ...]:
        """Choose again for every instance concerned since the last call; return what changed."""
        concerned, self._concerned = sorted(self._concerned), set()
        chosen = {i: self._choose(i) for i in concerned}
        images = self._instance_images(chosen)
        changed = []
        for instance_id, seqs in chosen.items():
            views = tuple(self._view(seq, images, instance_id) for seq in seqs)
            if self._replace(ViewSet(instance_id, views)):
                changed.append(self._view_sets.get(instance_id, ViewSet(instance_id, ())))
        return tuple(changed)

    def view_sets(self) -> tuple[ViewSet, ...]:
        """Return the view sets of all instances that have views, by instance id."""
        return tuple(self._view_sets[i] for i in sorted(self._view_sets))

    def image(self, seq: int) -> bytes | None:
        """Return the JPEG of a keyframe, ``None`` when it is gone; safe from any thread."""
        return self.archive.jpeg(seq)
