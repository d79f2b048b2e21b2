"""The map: voxels, superpoints and instances, frame by frame."""

from dataclasses import dataclass, field, replace

import numpy as np

from sceneq_core.arrays import Int32, UInt16
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.frame import Frame
from sceneq_core.mapping.association import Association, AssociationParams
from sceneq_core.mapping.delta import Instance, MapDelta
from sceneq_core.mapping.free_space import FreeSpaceParams, clear_free_space
from sceneq_core.mapping.gravity import Gravity, GravityParams
from sceneq_core.mapping.partition import SuperpointParams
from sceneq_core.mapping.published import Published
from sceneq_core.mapping.registry import Members, Registry, RegistryParams
from sceneq_core.mapping.rows import distinct
from sceneq_core.mapping.superpoints import Superpoints
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
    min_superpoint_pixels: int = 3
    publish_step_m: float = 0.002
    surface: SurfaceParams = field(default_factory=SurfaceParams)
    free_space: FreeSpaceParams = field(default_factory=FreeSpaceParams)
    superpoints: SuperpointParams = field(default_factory=SuperpointParams)
    association: AssociationParams = field(default_factory=AssociationParams)
    instances: RegistryParams = field(default_factory=RegistryParams)
    gravity: GravityParams = field(default_factory=GravityParams)

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
        self._voxels = Voxels(params.voxel_size_m)
        self._superpoints = Superpoints(params.superpoints)
        self._association = Association(params.association)
        self._registry = Registry(params.instances)
        self._gravity = Gravity(params.gravity)
        self._up_world = self._gravity.up_world()
        self._published = Published(params.publish_step_m)
        self._keyframes = 0
        self._last_seq = -1
        self._last_stamp_ns = 0

    def integrate(self, frame: Frame, label_image: UInt16) -> MapDelta:
        """Add a keyframe with its segments, uint16 (H, W), 0 = none; return what changed.

        Raises:
            ValueError: ``label_image`` has another size than the frame, the pose is not finite or
                more than ``COORD_LIMIT`` voxels from the origin. The map is unchanged then.
        """
        _check(frame, label_image)
        params, voxels, keyframe = self._params, self._voxels, self._keyframes
        # Voxels: average what is seen, empty what is seen through.
        surface = measure_surface(frame, params.surface)
        touched = voxels.integrate(surface)
        cleared = clear_free_space(voxels, frame, touched.voxel_id, params.free_space)
        self._gravity.add(voxels.normals_world(touched.new_id), frame.T_world_camera)
        self._up_world = self._gravity.up_world()
        # Superpoints: partition anew only where the surface changed.
        renewed, change = self._superpoints.update(voxels, touched.voxel_id, cleared, keyframe)
        concerned = distinct(np.concatenate((renewed, touched.voxel_id)), len(voxels))
        published = self._published.renew(voxels, self._superpoints, concerned)
        retracted = self._published.retract(cleared)
        # Evidence: which 2D segment dominates each visible superpoint; who agrees with whom.
        visible = self._visible(surface, touched, label_image)
        groups = self._association.update(change, visible, keyframe)
        # Instances: groups seen well enough, under ids that stay.
        instances = self._registry.update(groups, self._members, frame.stamp_ns, self._up_world)
        self._keyframes += 1
        self._last_seq, self._last_stamp_ns = frame.seq, frame.stamp_ns
        return self._delta(False, published, retracted, instances)

    def snapshot(self) -> MapDelta:
        """Return the whole map: what all deltas so far add up to, without what was removed."""
        instances = tuple(i for _, i in sorted(self._registry.instances.items()))
        return self._delta(True, self._published.all_ids(), np.zeros(0, np.int32), instances)

    def unchanged(self, seq: int, stamp_ns: int) -> MapDelta:
        """Return a delta without content that names frame ``seq``."""
        none = np.zeros(0, np.int32)
        return replace(self._delta(False, none, none, ()), frame_seq=seq, stamp_ns=stamp_ns)

    def counts(self) -> dict[str, int]:
        """Return the size of the map for a health report."""
        return {"voxels": self._published.count, "instances": len(self._registry.instances)}

    def _visible(self, surface: SurfacePoints, touched: Touched, label_image: UInt16) -> Visible:
        superpoint = self._superpoints.of(touched.voxel_id)[touched.of_point]
        label = label_image[surface.row, surface.column]
        return visible_superpoints(superpoint, label, self._params.min_superpoint_pixels)

    def _members(self, group: int) -> Members:
        superpoint_id = self._association.members(group)
        voxel_id = self._superpoints.voxels(self._voxels, superpoint_id)
        return Members(superpoint_id, self._published.points_world[voxel_id])

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
