"""Which of the upright planes bound the scene."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_between, need_positive
from sceneq_core.mapping.planes import Pieces, Plane, upright_planes


@dataclass(frozen=True, slots=True)
class WallParams:
    """What a wall is, apart from large and upright.

    ``min_area_m2`` of visible surface that reaches ``min_top_m`` above the floor, which the front
    of a kitchen counter does not; ``lean_deg`` how far the normal of a small piece may be off.
    Of two planes that face the same way up to ``depth_m`` apart one is furniture or a recess:
    nearer than ``recess_m`` (a door, a window) the larger is the wall, else the one behind, if it
    has ``min_behind`` of the other's area. ``beside_m`` apart sideways they are still neighbours.
    """

    min_area_m2: float = 1.5
    min_top_m: float = 1.2
    lean_deg: float = 25.0
    depth_m: float = 1.0
    recess_m: float = 0.3
    min_behind: float = 0.3
    beside_m: float = 0.5

    def __post_init__(self) -> None:
        need_positive(
            self, "min_area_m2", "min_top_m", "depth_m", "recess_m", "min_behind", "beside_m"
        )
        need_between(self, 0, 45, "lean_deg")


@dataclass(frozen=True, slots=True)
class _Span:
    """A plane with its area, the middle of its surface and its extent sideways and upwards."""

    plane: Plane
    area_m2: float
    middle_world: Float64
    sideways_world: Float64
    sideways_m: Float64
    height_m: Float64


def find_walls(
    pieces: Pieces, up_world: Float64, floor_m: float, params: WallParams
) -> tuple[Plane, ...]:
    """Return the planes that bound the scene, their normals to the inside.

    ``floor_m`` is the height of the floor along ``up_world``, minus infinity = not known.
    """
    found = upright_planes(pieces, up_world, params.lean_deg, params.min_area_m2)
    spans = [_span(pieces, plane, area_m2, up_world, params.lean_deg) for plane, area_m2 in found]
    return tuple(
        one.plane
        for one in spans
        if one.height_m[1] >= floor_m + params.min_top_m
        and not any(_yields_to(one, other, params) for other in spans if other is not one)
        and _behind_m2(pieces, one, up_world, params) <= params.min_behind * one.area_m2
    )


def _span(
    pieces: Pieces, plane: Plane, area_m2: float, up_world: Float64, lean_deg: float
) -> _Span:
    facing = pieces.normal_world @ plane.normal_world > np.cos(np.deg2rad(lean_deg))
    on = pieces.centre_world[facing & (np.abs(plane.height_m(pieces.centre_world)) < 0.08)]
    sideways = np.cross(up_world, plane.normal_world)
    return _Span(
        plane=plane,
        area_m2=area_m2,
        middle_world=on.mean(axis=0),
        sideways_world=sideways,
        sideways_m=np.percentile(on @ sideways, (3, 97)),
        height_m=np.percentile(on @ up_world, (5, 95)),
    )


def _yields_to(one: _Span, other: _Span, params: WallParams) -> bool:
    """Tell whether ``one`` is furniture in front of ``other``, or a recess in it."""
    if one.plane.normal_world @ other.plane.normal_world < np.cos(np.deg2rad(15.0)):
        return False
    low, high = other.sideways_m
    mine = one.sideways_m
    if mine[0] > high + params.beside_m or mine[1] < low - params.beside_m:
        return False
    before_m = float(other.plane.height_m(one.middle_world))
    if abs(before_m) > params.depth_m:
        return False
    if abs(before_m) < params.recess_m:
        return other.area_m2 > one.area_m2
    if before_m > 0:
        return other.area_m2 > params.min_behind * one.area_m2
    return params.min_behind * other.area_m2 > one.area_m2


def _behind_m2(pieces: Pieces, span: _Span, up_world: Float64, params: WallParams) -> float:
    """Return how much surface can be seen close behind a plane, within its outline.

    What faces the other way is the back of the wall, seen from the next room.
    """
    depth = -span.plane.height_m(pieces.centre_world)
    sideways, height = pieces.centre_world @ span.sideways_world, pieces.centre_world @ up_world
    inside = (sideways > span.sideways_m[0]) & (sideways < span.sideways_m[1])
    inside &= (height > span.height_m[0]) & (height < span.height_m[1])
    inside &= (depth > params.recess_m) & (depth < params.depth_m)
    inside &= pieces.normal_world @ span.plane.normal_world > -0.3
    return float(pieces.area_m2[inside].sum())
