"""The map: voxels, superpoints and instances, frame by frame."""

from dataclasses import dataclass, field, replace

import numpy as np

from sceneq_core.arrays import Float64, Int32, UInt16
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.frame import Frame
from sceneq_core.mapping.association import Association
from sceneq_core.mapping.association_params import AssociationParams
from sceneq_core.mapping.colours import colours_in_view
from sceneq_core.mapping.contacts import contacts_in_view
from sceneq_core.mapping.correction import (
    Anchors,
    Correction,
    CorrectionParams,
    move_surface,
)
from sceneq_core.mapping.delta import REMOVED, Instance, MapDelta
from sceneq_core.mapping.free_space import FreeSpaceParams, find_seen_through
from sceneq_core.mapping.gravity import Gravity, GravityParams
from sceneq_core.mapping.joined import joined
from sceneq_core.mapping.members import Members
from sceneq_core.mapping.partition import SuperpointParams
from sceneq_core.mapping.presence import Presence, PresenceParams
from sceneq_core.mapping.proposals import Proposals
from sceneq_core.mapping.proposed import ProposalParams, Proposed
from sceneq_core.mapping.published import Published
from sceneq_core.mapping.quarantine import Quarantine, QuarantineParams
from sceneq_core.mapping.registry import Registry, RegistryParams
from sceneq_core.mapping.reunion import group_of, reunite
from sceneq_core.mapping.scene_clock import SceneClock
from sceneq_core.mapping.scene_graph import SceneGraph, SceneGraphParams
from sceneq_core.mapping.superpoints import SuperpointChange, Superpoints
from sceneq_core.mapping.surface import SurfaceParams, SurfacePoints, measure_surface
from sceneq_core.mapping.visibility import Visible, visible_superpoints
from sceneq_core.mapping.voxels import Touched, Voxels


@dataclass(frozen=True, slots=True)
class MapperParams:
    """All parameters of the map.

    ``voxel_size_m`` edge of a voxel; ``min_superpoint_pixels`` surface points from which a
    superpoint counts as seen; ``publish_step_m`` how far a voxel's mean moves before readers are
    told.
    """

    voxel_size_m: float = 0.02
    min_superpoint_pixels: int = 1
    publish_step_m: float = 0.002
    surface: SurfaceParams = field(default_factory=SurfaceParams)
    free_space: FreeSpaceParams = field(default_factory=FreeSpaceParams)
    presence: PresenceParams = field(default_factory=PresenceParams)
    superpoints: SuperpointParams = field(default_factory=SuperpointParams)
    association: AssociationParams = field(default_factory=AssociationParams)
    instances: RegistryParams = field(default_factory=RegistryParams)
    gravity: GravityParams = field(default_factory=GravityParams)
    correction: CorrectionParams = field(default_factory=CorrectionParams)
    scene_graph: SceneGraphParams = field(default_factory=SceneGraphParams)
    quarantine: QuarantineParams = field(default_factory=QuarantineParams)
    proposed: ProposalParams = field(default_factory=ProposalParams)

    def __post_init__(self) -> None:
        need_positive(self, "voxel_size_m")
        need_at_least(self, 1, "min_superpoint_pixels")
        need_at_least(self, 0, "publish_step_m")


class Mapper:
    """Grows a map from posed frames with 2D segments. Same frames, same order: same bits.

    The offline method in four steps a keyframe: voxels, superpoints, evidence of the 2D segments,
    instances. Every step touches only what the keyframe touched
    (docs/adr/0006-the-first-map.md says what that changes against a finished scan).
    """

    def __init__(self, params: MapperParams) -> None:
        self._params = params
        self._quarantine = Quarantine(params.quarantine)
        self._proposed = Proposed(params.proposed)
        self._voxels = Voxels(params.voxel_size_m)
        self._superpoints = Superpoints(params.superpoints)
        self._association = Association(params.association)
        self._presence = Presence(params.presence)
        self._registry = Registry(params.instances, self._presence)
        self._gravity = Gravity(params.gravity)
        self._up_world = self._gravity.up_world()
        self._scene_graph = SceneGraph(params.scene_graph, params.voxel_size_m)
        self._published = Published(params.publish_step_m)
        self._anchors = Anchors()
        self._keyframes = 0
        self._clock = SceneClock()
        self._last_seq, self._last_stamp_ns = -1, 0

    def integrate(self, frame: Frame, label_image: UInt16) -> MapDelta:
        """Add a keyframe with its segments, uint16 (H, W), 0 = none; return what changed.

        A keyframe that would harm the map changes nothing, and the delta says why; one that was
        held back comes with the later one that proves it right.

        Raises:
            ValueError: ``label_image`` has another size than the frame, the pose is not finite or
                more than ``COORD_LIMIT`` voxels from the origin. The map is unchanged then.
        """
        _check(frame, label_image)
        admitted = self._quarantine.admit(frame, label_image)
        if admitted.reason:
            nothing = self.unchanged(frame.seq, frame.stamp_ns)
            return replace(nothing, quarantined=admitted.reason)
        return joined([self._integrate(*keyframe) for keyframe in admitted.keyframes])

    def _integrate(self, frame: Frame, label_image: UInt16) -> MapDelta:
        params, voxels, keyframe = self._params, self._voxels, self._keyframes
        # Voxels: average what is seen, empty what is seen through.
        surface = measure_surface(frame, params.surface)
        anchor = self._anchors.add(frame.seq, frame.T_world_camera)
        touched = voxels.integrate(surface, anchor)
        now_ns = self._clock.tick(frame.seq, frame.stamp_ns)
        cleared = self._clear(frame, touched, now_ns)
        self._gravity.add(voxels.normals_world(touched.new_id), frame.T_world_camera)
        self._up_world = self._up()
        # Superpoints: partition anew only where the surface changed.
        renewed, change = self._superpoints.update(voxels, touched.voxel_id, cleared, keyframe)
        published = self._published.renew(voxels, self._superpoints, touched.voxel_id, renewed)
        retracted = self._published.retract(cleared)
        # Evidence: which 2D segment dominates each visible superpoint; who agrees with whom.
        visible = self._visible(surface, touched, label_image)
        entering = self._proposed.entering(
            renewed, change, voxels, self._superpoints, self._association
        )
        groups = self._association.update(change, visible, keyframe, entering)
        # Instances: groups seen well enough, under ids that stay.
        instances, events = self._registry.update(groups, self._members, now_ns, self._up_world)
        # Scene graph: what is floor or wall; what stands on, in and next to what.
        instances = self._relate(renewed, change, instances)
        self._keyframes += 1
        self._last_seq, self._last_stamp_ns = frame.seq, frame.stamp_ns
        return replace(self._delta(False, published, retracted, instances), events=events)

    def propose(self, proposals: Proposals) -> None:
        """Let external masks found the instances of surface that is seen from now on.

        They go through the same refinement as those of the 2D segments, which split and merge them.
        """
        self._proposed.take(proposals)

    def correct(self, correction: Correction) -> MapDelta:
        """Move the surface that was put down with poses known better now; return the whole map.

        Superpoints, evidence and instances go along with their ids. Groups that come to lie in one
        another are one thing that was mapped twice, and merge. Without any change the delta is
        empty and not ``full``.

        Raises:
            ValueError: a pose that is no rigid motion, or one that leads out of the grid. The map
                is unchanged then.
        """
        motions = self._anchors.motions(correction)
        if not motions.moved.any():
            return self.unchanged(self._last_seq, self._last_stamp_ns)
        surface_id = self._voxels.occupied(np.arange(len(self._voxels), dtype=np.int32))
        before = group_of(self._association, self._superpoints, surface_id)
        moved = move_surface(self._voxels, motions)
        self._anchors.take(correction)
        self._quarantine.correct(correction)
        self._presence.carry(self._voxels, moved)
        renewed, change = self._superpoints.carry(self._voxels, moved)
        self._published.retract(np.setdiff1d(moved.from_id, moved.to_id))
        self._published.renew(self._voxels, self._superpoints, renewed, renewed)
        now_id = moved.where(surface_id, len(self._voxels))
        groups = reunite(
            self._association,
            self._superpoints,
            change,
            self._keyframes,
            (before, now_id),
            self._params.correction,
        )
        news, events = self._registry.update(
            groups, self._members, self._clock.now_ns, self._up_world
        )
        news = self._relate(renewed, change, news)
        delta = self.snapshot()
        elsewhere = moved.from_id != moved.to_id
        return replace(
            delta,
            instances=delta.instances + tuple(i for i in news if i.state == REMOVED),
            events=events,
            moved_from_id=moved.from_id[elsewhere],
            moved_to_id=moved.to_id[elsewhere],
        )

    def snapshot(self) -> MapDelta:
        """Return the whole map: what all deltas so far add up to, without what was removed."""
        instances = tuple(i for _, i in sorted(self._scene_graph.instances.items()))
        return self._delta(True, self._published.all_ids(), np.zeros(0, np.int32), instances)

    def unchanged(self, seq: int, stamp_ns: int) -> MapDelta:
        """Return a delta without content that names frame ``seq``."""
        none = np.zeros(0, np.int32)
        return replace(self._delta(False, none, none, ()), frame_seq=seq, stamp_ns=stamp_ns)

    @property
    def params(self) -> MapperParams:
        """Return the parameters of the map."""
        return self._params

    @property
    def let_in(self) -> int:
        """Return how many keyframes were quarantined first and let in later."""
        return self._quarantine.let_in

    def counts(self) -> dict[str, int]:
        """Return the size of the map for a health report."""
        return {"voxels": self._published.count, "instances": len(self._registry.instances)}

    def _up(self) -> Float64:
        """Return up as given, or as the floor tells it, or as estimated until there is one."""
        estimate_world = self._gravity.up_world()
        is_given = self._params.gravity.up_world is not None
        return estimate_world if is_given else self._scene_graph.up_world(estimate_world)

    def _relate(
        self, renewed: Int32, change: SuperpointChange, news: tuple[Instance, ...]
    ) -> tuple[Instance, ...]:
        return self._scene_graph.update(
            self._voxels,
            self._superpoints,
            renewed,
            change.gone_id,
            news,
            self._gravity.up_world(),
        )

    def _visible(self, surface: SurfacePoints, touched: Touched, label_image: UInt16) -> Visible:
        of_voxel = self._superpoints.of(touched.voxel_id)
        superpoint = of_voxel.take(touched.of_point)
        pixel = surface.row * label_image.shape[1] + surface.column
        label = label_image.reshape(-1).take(pixel)
        visible = visible_superpoints(superpoint, label, self._params.min_superpoint_pixels)
        voxel_id = touched.voxel_id.take(touched.of_point)
        stride_px = self._params.surface.stride_px
        contacts = contacts_in_view(superpoint, voxel_id, surface, stride_px, self._voxels)
        colours = colours_in_view(of_voxel, self._published.rgb.take(touched.voxel_id, axis=0))
        return replace(visible, contacts=contacts, colours=colours)

    def _members(self, group: int) -> Members:
        superpoint_id = self._association.members(group)
        voxel_id = self._superpoints.voxels(superpoint_id)
        points_world = self._published.points_world.take(voxel_id, axis=0)
        rgb = self._published.rgb.take(voxel_id, axis=0)
        return Members(superpoint_id, voxel_id, points_world, rgb)

    def _clear(self, frame: Frame, touched: Touched, now_ns: int) -> Int32:
        """Empty the voxels of what is not there any more; return them, sorted."""
        through = find_seen_through(self._voxels, touched.voxel_id, frame, self._params.free_space)
        self._superpoints.reserve(len(self._voxels))
        look = self._presence.look(self._voxels, touched.voxel_id, through, self._group_of, now_ns)
        gone = self._registry.look(look, self._members)
        self._presence.clear(self._voxels, gone.voxel_id)
        self._association.dissolve(gone.group)
        return gone.voxel_id

    def _group_of(self, voxel_id: Int32) -> Int32:
        """Return the groups of voxels as of the last keyframe, -1 = none."""
        group = np.append(self._association.of(np.arange(len(self._superpoints))), np.int32(-1))
        return group[self._superpoints.of(voxel_id)]

    def _delta(
        self,
        full: bool,
        voxel_id: Int32,
        removed_voxel_id: Int32,
        instances: tuple[Instance, ...],
    ) -> MapDelta:
        return MapDelta(
            full=full,
            frame_seq=self._last_seq,
            stamp_ns=self._last_stamp_ns,
            voxel_size_m=self._params.voxel_size_m,
            up_world=self._up_world,
            voxel_id=voxel_id,
            voxel_coord=self._voxels.coord(voxel_id),
            points_world=self._published.points_world[voxel_id],
            rgb=self._published.rgb[voxel_id],
            superpoint_id=self._published.superpoint_id[voxel_id],
            removed_voxel_id=removed_voxel_id,
            instances=instances,
        )


def _check(frame: Frame, label_image: UInt16) -> None:
    if label_image.shape != frame.depth_m.shape:
        raise ValueError(f"label_image: expected {frame.depth_m.shape}, got {label_image.shape}")
    if not np.isfinite(frame.T_world_camera).all():
        raise ValueError(f"T_world_camera: not finite in frame {frame.seq}")
