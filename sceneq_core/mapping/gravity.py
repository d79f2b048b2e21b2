"""Which way is up, from the horizontal surfaces of the scene and how the camera is held."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_between
from sceneq_core.vectors import unit_rows

_BINS_PER_UNIT = 8
_SIDE = 2 * _BINS_PER_UNIT + 1


@dataclass(frozen=True, slots=True)
class GravityParams:
    """How up is estimated.

    ``up_world`` fixes the direction when the source knows it; ``cone_deg`` is how far a surface
    may lean to count as horizontal; below ``min_voxels`` such voxels the camera alone decides.
    """

    up_world: tuple[float, float, float] | None = None
    cone_deg: float = 15.0
    min_voxels: int = 500

    def __post_init__(self) -> None:
        if self.up_world is not None and not np.linalg.norm(self.up_world) > 0.0:
            raise ValueError(f"up_world: must not be zero, got {self.up_world}")
        need_between(self, 0, 45, "cone_deg")
        need_at_least(self, 1, "min_voxels")


class Gravity:
    """A histogram of the normals of all surfaces and the mean up axis of the camera.

    People and robots hold a camera roughly upright, which says which of the dominant planes is
    the floor; the planes say precisely where up is.
    """

    def __init__(self, params: GravityParams) -> None:
        self._params = params
        self._normal_sum = np.zeros((_SIDE**3, 3))
        self._area = np.zeros(_SIDE**3)
        self._camera_up_sum = np.zeros(3)
        self._up_world: Float64 | None = None

    def add(self, normals_world: Float64, T_world_camera: Float64) -> None:
        """Count normals float64 (N, 3) of newly found surface and the pose that saw them."""
        self._up_world = None
        self._camera_up_sum -= T_world_camera[:3, 1]
        cube = np.rint(normals_world * _BINS_PER_UNIT).astype(np.int64) + _BINS_PER_UNIT
        place = (cube[:, 0] * _SIDE + cube[:, 1]) * _SIDE + cube[:, 2]
        self._area += np.bincount(place, minlength=_SIDE**3)
        for axis in range(3):
            self._normal_sum[:, axis] += np.bincount(place, normals_world[:, axis], _SIDE**3)

    def up_world(self) -> Float64:
        """Return the unit vector against gravity, float64 (3,), world frame."""
        if self._params.up_world is not None:
            return _unit(np.array(self._params.up_world, np.float64))
        if self._up_world is None:
            self._up_world = self._estimate()
        return self._up_world

    def _estimate(self) -> Float64:
        camera_up = _unit(self._camera_up_sum)
        normal = self._dominant_normal(camera_up)
        if normal is None:
            return camera_up
        return normal if normal @ camera_up > 0 else -normal

    def _dominant_normal(self, camera_up: Float64) -> Float64 | None:
        """Return the mean normal (3,), up or down, of the parallel surfaces most likely level.

        Those are large and lie across the camera's up axis. ``None`` = too little surface.
        """
        # A normal and its opposite are one axis, and their bins lie as far from either end.
        axis_area = (self._area + self._area[::-1])[: _SIDE**3 // 2]
        axis_sum = (self._normal_sum - self._normal_sum[::-1])[: _SIDE**3 // 2]
        used = np.flatnonzero(axis_area > 0)
        axes, area = unit_rows(axis_sum[used]), axis_area[used]
        parallel = np.abs(axes @ axes.T) > np.cos(np.deg2rad(self._params.cone_deg))
        parallel_area = parallel @ area
        best = int(np.argmax(parallel_area * (axes @ camera_up) ** 2)) if len(used) else -1
        if best < 0 or parallel_area[best] < self._params.min_voxels:
            return None
        alike = axes[parallel[best]]
        # Floor and ceiling are one direction: axes are turned to the same side.
        side = np.sign(alike @ axes[best]) * area[parallel[best]]
        return _unit((alike * side[:, None]).sum(axis=0))


def _unit(vector: Float64) -> Float64:
    length = float(np.sqrt((vector**2).sum()))
    return vector / length if length > 0 else np.array([0.0, 0.0, 1.0])
