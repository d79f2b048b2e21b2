"""Floor, walls and ceiling: which planes they are, and which instances are part of them."""

from dataclasses import dataclass, field

import numpy as np

from sceneq_core.arrays import Float64, Int32
from sceneq_core.checks import need_at_least, need_between, need_positive, need_within
from sceneq_core.mapping.delta import CEILING, FLOOR, OBJECT, WALL
from sceneq_core.mapping.patches import Patches
from sceneq_core.mapping.planes import Pieces, Plane, level_planes
from sceneq_core.mapping.rows import with_rows
from sceneq_core.mapping.walls import WallParams, find_walls

NO_PLANE = -1
_NEW_UP_DEG = 10.0
"""When the estimate of up has changed so much, what was found with the old one is void."""


@dataclass(frozen=True, slots=True)
class StructureParams:
    """When a plane is structure, and an instance part of it.

    The lowest level plane of ``min_level_m2`` is the floor; one seen from below, ``min_room_m``
    above the floor, is the ceiling. A patch lies on a plane within ``reach_m``, its normal within
    ``lean_deg``. An instance is structure when ``min_share`` of it lies on the plane and it does
    not look like a thing on it: on average it is within ``max_colour`` (CIELAB, lightness by half)
    of the colour of the plane and does not stand out more than the plane is rough (at least
    ``min_relief_m``), or it makes up ``main_share`` of the plane and is even to ``max_texture``.
    Planes are looked for again when the surface has grown or shrunk by ``growth``.
    """

    min_level_m2: float = 0.5
    min_room_m: float = 1.8
    reach_m: float = 0.05
    lean_deg: float = 35.0
    min_share: float = 0.6
    max_colour: float = 10.0
    min_relief_m: float = 0.005
    main_share: float = 0.3
    max_texture: float = 9.0
    growth: float = 0.15
    walls: WallParams = field(default_factory=WallParams)

    def __post_init__(self) -> None:
        need_positive(self, "min_level_m2", "min_room_m", "reach_m", "max_colour", "max_texture")
        need_between(self, 0, 90, "lean_deg")
        need_within(self, 0, 1, "min_share", "main_share")
        need_at_least(self, 0, "min_relief_m", "growth")


@dataclass(frozen=True, slots=True)
class StructurePlane:
    """A plane of the building with what its surface is like.

    ``lab`` (3,) its median colour, ``roughness_m`` the median distance of its patches from it,
    ``voxels`` how many lie on it.
    """

    role: str
    plane: Plane
    lab: Float64
    roughness_m: float
    voxels: float


class Structure:
    """The planes of floor, walls and ceiling, and the plane that each superpoint lies on.

    Attributes:
        planes: as last found; replaced as a whole.
        floor: the first of ``planes`` when it is a floor, else ``None``.
    """

    _MIN_PATCH_VOXELS = 5

    def __init__(self, params: StructureParams, voxel_size_m: float) -> None:
        self._params = params
        self._voxel_m2 = voxel_size_m**2
        self._of_superpoint = np.full(0, NO_PLANE, np.int32)
        self._voxels_then = 0.0
        self._up_then = np.zeros(3)
        self._found: tuple[tuple[str, Plane], ...] = ()
        self.planes: tuple[StructurePlane, ...] = ()

    @property
    def floor(self) -> Plane | None:
        """The plane of the floor, its normal upwards."""
        return self.planes[0].plane if self.planes and self.planes[0].role == FLOOR else None

    def update(self, patches: Patches, changed_id: Int32, up_world: Float64) -> bool:
        """Follow changed superpoints; return whether the planes were looked for anew."""
        voxels = float(patches.voxels.sum())
        anew = abs(voxels - self._voxels_then) > self._params.growth * self._voxels_then
        anew |= bool(up_world @ self._up_then < np.cos(np.deg2rad(_NEW_UP_DEG)))
        if anew:
            self._voxels_then, self._up_then = voxels, up_world
            self._found = self._find(patches, up_world)
            changed_id = np.arange(len(patches.voxels), dtype=np.int32)
        self._of_superpoint = with_rows(self._of_superpoint, len(patches.voxels), NO_PLANE)
        self._of_superpoint[changed_id] = self._nearest(patches, changed_id)
        if anew:
            self.planes = tuple(self._describe(patches, row) for row in range(len(self._found)))
        return anew

    def plane_of(self, patches: Patches, superpoint_id: Int32) -> int:
        """Return the row in ``planes`` that an instance of these superpoints is part of, or -1."""
        on, voxels = self._of_superpoint[superpoint_id], patches.voxels[superpoint_id]
        area = np.bincount(on + 1, voxels, len(self.planes) + 1)[1:]
        if area.max(initial=0.0) == 0.0 or area.max() < self._params.min_share * voxels.sum():
            return NO_PLANE
        row = int(area.argmax())
        part = superpoint_id[on == row]
        return row if self._looks_like(patches, part, self.planes[row]) else NO_PLANE

    def role_of(self, plane: int) -> str:
        """Return the role of what is part of the plane in row ``plane`` of ``planes``."""
        return self.planes[plane].role if plane != NO_PLANE else OBJECT

    def _looks_like(self, patches: Patches, part: Int32, plane: StructurePlane) -> bool:
        """Tell a part of the building from a picture, a door or a rug that lies on its plane."""
        params, voxels = self._params, patches.voxels[part]
        if voxels.sum() >= params.main_share * plane.voxels:
            texture = _spread(patches.lab[part], weighted_median(patches.lab[part], voxels), voxels)
            return plane.role == FLOOR or texture <= params.max_texture
        if _spread(patches.lab[part], plane.lab, voxels) > params.max_colour:
            return False
        height = plane.plane.height_m(patches.centre_world[part])[:, None]
        relief = weighted_median(height, voxels)[0]
        return bool(relief <= max(params.min_relief_m, plane.roughness_m))

    def _find(self, patches: Patches, up_world: Float64) -> tuple[tuple[str, Plane], ...]:
        params = self._params
        usable = np.flatnonzero(patches.voxels >= self._MIN_PATCH_VOXELS)
        pieces = Pieces(
            patches.centre_world[usable],
            patches.normal_world[usable],
            patches.voxels[usable] * self._voxel_m2,
        )
        lean_deg = params.walls.lean_deg
        floors = level_planes(pieces, up_world, lean_deg, params.min_level_m2)[:1]
        up = floors[0].normal_world if floors else up_world
        ceilings = level_planes(pieces, -up, lean_deg, params.min_level_m2)[:1]
        ceilings = tuple(c for c in ceilings if not floors or self._is_over(c, floors[0]))
        floor_m = floors[0].offset_m if floors else -np.inf
        walls = find_walls(pieces, up, floor_m, params.walls)
        return (
            *((FLOOR, floor) for floor in floors),
            *((CEILING, ceiling) for ceiling in ceilings),
            *((WALL, wall) for wall in walls),
        )

    def _is_over(self, ceiling: Plane, floor: Plane) -> bool:
        """Tell whether there is room to stand between the two."""
        return -ceiling.offset_m - floor.offset_m >= self._params.min_room_m

    def _nearest(self, patches: Patches, superpoint_id: Int32) -> Int32:
        """Return the plane that each superpoint lies on, -1 = none."""
        nearest = np.full(len(superpoint_id), NO_PLANE, np.int32)
        closest = np.full(len(superpoint_id), self._params.reach_m)
        centre, normal = patches.centre_world[superpoint_id], patches.normal_world[superpoint_id]
        for row, (_, plane) in enumerate(self._found):
            away = np.abs(plane.height_m(centre))
            facing = normal @ plane.normal_world > np.cos(np.deg2rad(self._params.lean_deg))
            on = (away < closest) & facing
            nearest[on], closest[on] = row, away[on]
        return nearest

    def _describe(self, patches: Patches, row: int) -> StructurePlane:
        role, plane = self._found[row]
        on = np.flatnonzero((self._of_superpoint == row)[: len(patches.voxels)])
        voxels = patches.voxels[on]
        away = np.abs(plane.height_m(patches.centre_world[on]))[:, None]
        return StructurePlane(
            role=role,
            plane=plane,
            lab=weighted_median(patches.lab[on], voxels),
            roughness_m=float(weighted_median(away, voxels)[0]),
            voxels=float(voxels.sum()),
        )


def _spread(lab: Float64, middle: Float64, weight: Float64) -> float:
    """Return the mean distance of colours (N, 3) from ``middle``."""
    return float(np.linalg.norm(lab - middle, axis=1) @ weight / weight.sum())


def weighted_median(rows: Float64, weight: Float64) -> Float64:
    """Return the median float64 (C,) of each column of ``rows`` (N, C); 0 when N = 0."""
    if not len(rows):
        return np.zeros(rows.shape[1])
    order = np.argsort(rows, axis=0, kind="stable")
    reached = np.cumsum(weight[order], axis=0)
    middle = (reached < reached[-1] / 2.0).sum(axis=0)
    median: Float64 = np.take_along_axis(rows, order, axis=0)[middle, np.arange(rows.shape[1])]
    return median
