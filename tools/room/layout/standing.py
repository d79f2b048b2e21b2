"""Finding places on the floor: at walls, in corners, in the middle, and near other furniture."""

import math
from collections.abc import Callable, Iterator

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.layout.draft import Draft, Zone
from sceneq_tools.room.layout.footprint import Footprint
from sceneq_tools.room.layout.placement import footprint, front_area, pose
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.layout.stock import Item
from sceneq_tools.room.layout.wall import Wall
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.room import Thing

WALL_GAP_M = 0.025
"""Skirting boards keep furniture this far from the wall."""

STEP_M = 0.1
"""How closely places along a wall are looked at."""

HEADROOM_M = {"tv_stand": 0.7, "filing_cabinet": 0.4, "dresser": 0.3}
"""What will stand on furniture of these roles is not to be seen against a window."""

TUCK_STEP_M = 0.03
"""How far a chair is pulled out at a time until it clears the table."""


def stand_at_wall(draft: Draft, item: Item, where: str, front_m: float) -> Thing | None:
    """Stand something with its back to a wall, with free floor in front of it."""
    low, high = bounds(item.mesh)
    half_width = float(high[0] - low[0]) / 2
    best: tuple[float, Wall, Float64] | None = None
    for wall in draft.walls:
        for along in np.arange(half_width + 0.03, wall.length_m - half_width - 0.03, STEP_M):
            cost = _wall_cost(draft, wall, float(along), half_width, where)
            if best is not None and cost >= best[0]:
                continue
            T_world = backed(item.mesh, wall, float(along))
            if draft.fits(item.mesh, T_world, headroom_m=_headroom(item)) and draft.is_clear(
                front_area(item.mesh, T_world, front_m)
            ):
                best = (cost, wall, T_world)
    return None if best is None else _stood(draft, item, best[2], best[1], front_m)


def stand_in_middle(draft: Draft, item: Item, around_m: float) -> Thing | None:
    """Stand something freely, as near to the middle of the room as there is space around it."""
    width, depth, _ = draft.size_m
    places = draft.rng.uniform((0.8, 0.8), (width - 0.8, depth - 0.8), (150, 2))
    centre = np.array([width / 2, depth / 2])
    order = np.argsort(np.linalg.norm(places - centre, axis=1) + draft.rng.uniform(0, 0.6, 150))
    for x, y in places[order]:
        T_world = pose(x, y, 0.0, float(draft.rng.choice([0.0, math.pi / 2])))
        if draft.fits(item.mesh, T_world, around_m):
            return _stood(draft, item, T_world, None, 0.0)
    return None


def stand_anywhere(draft: Draft, item: Item, at_wall: bool) -> Thing | None:
    """Stand something small on free floor, near a wall when asked, turned at random."""
    for _ in range(60):
        if at_wall:
            wall = draft.walls[int(draft.rng.integers(4))]
            along = float(draft.rng.uniform(0.2, wall.length_m - 0.2))
            T_world = backed(item.mesh, wall, along, draft.rng.uniform(0.02, 0.08))
        else:
            x, y = draft.rng.uniform((0.3, 0.3), (draft.size_m[0] - 0.3, draft.size_m[1] - 0.3))
            T_world = pose(x, y, 0.0, float(draft.rng.uniform(-math.pi, math.pi)))
        if draft.fits(item.mesh, T_world, 0.03):
            return draft.stand(item, T_world)
    return None


def stand_near(draft: Draft, host: Thing, item: Item, where: str, gap_m: float) -> Thing | None:
    """Stand something near a piece of furniture, in the first place that is free."""
    for T_world in FINDERS[where](draft, host, item.mesh, gap_m):
        if draft.fits(item.mesh, T_world, 0.03, (host.id,), _headroom(item)):
            thing = draft.stand(item, T_world)
            wall = draft.wall_of.get(host.id)
            if where == "beside" and wall is not None:
                draft.wall_of[thing.id] = wall
            if where == "across" and wall is not None:
                draft.wall_of[thing.id] = draft.walls[(wall.side + 2) % 4]
            return thing
    return None


def backed(mesh: Mesh, wall: Wall, along_m: float, gap_m: float = WALL_GAP_M) -> Float64:
    """Return the pose of a mesh with its back to a wall."""
    low, high = bounds(mesh)
    middle = (low + high) / 2
    return wall.pose(along_m - float(middle[0]), gap_m + float(high[1]))


Places = Callable[[Draft, Thing, Mesh, float], Iterator[Float64]]
"""Yields poses for a mesh near a host, the best first."""


def _wall_cost(draft: Draft, wall: Wall, along: float, half_width: float, where: str) -> float:
    """Return how unwelcome a place along a wall is; the noise makes rooms differ."""
    noise = float(draft.rng.uniform(0, 1))
    to_end = min(along, wall.length_m - along) - half_width
    if where == "corner":
        return to_end + 0.5 * noise
    if where == "centre":
        return abs(along - wall.length_m / 2) + 1.5 * noise
    return noise


def _headroom(item: Item) -> float:
    """Return how high things stand on it, metres."""
    return HEADROOM_M.get(item.category.role, 0.0)


def _stood(draft: Draft, item: Item, T_world: Float64, wall: Wall | None, front_m: float) -> Thing:
    thing = draft.stand(item, T_world)
    if wall is not None:
        draft.wall_of[thing.id] = wall
    if front_m > 0:
        draft.zones.append(Zone(front_area(item.mesh, T_world, front_m), owner=thing.id))
    return thing


def _beside(draft: Draft, host: Thing, mesh: Mesh, gap_m: float) -> Iterator[Float64]:
    """Yield places at both sides, backs in line."""
    own = footprint(host.mesh, host.T_world_thing)
    low, high = bounds(mesh)
    sides = [1.0, -1.0] if draft.rng.random() < 0.5 else [-1.0, 1.0]
    for further in (0.0, 0.15, 0.3):
        for side in sides:
            reach = own.half_width + gap_m + further + float(high[0] - low[0]) / 2
            yield _at(own, side * reach, own.half_depth - float(high[1] - low[1]) / 2, mesh, 0.0)


def _ahead(draft: Draft, host: Thing, mesh: Mesh, gap_m: float) -> Iterator[Float64]:
    """Yield places in front of the middle."""
    own = footprint(host.mesh, host.T_world_thing)
    low, high = bounds(mesh)
    for further in (0.0, 0.1, 0.2):
        reach = own.half_depth + gap_m + further + float(high[1] - low[1]) / 2
        yield _at(
            own, float(draft.rng.normal(0, 0.06)), -reach, mesh, float(draft.rng.normal(0, 0.03))
        )


def _tucked(draft: Draft, host: Thing, mesh: Mesh, gap_m: float) -> Iterator[Float64]:
    """Yield places under the front edge, facing the host, pulled out further and further."""
    own = footprint(host.mesh, host.T_world_thing)
    low, high = bounds(mesh)
    half_depth = float(high[1] - low[1]) / 2
    yield from _pulled_out(draft, own, mesh, 0.0, -1.0, own.half_depth + half_depth)


def _around(draft: Draft, host: Thing, mesh: Mesh, gap_m: float) -> Iterator[Float64]:
    """Yield seats at the long sides, then at the ends, all facing the host."""
    own = footprint(host.mesh, host.T_world_thing)
    low, high = bounds(mesh)
    half_width, half_depth = (high - low)[:2] / 2
    along = own.half_width * 0.5 if own.half_width > 2 * half_width + 0.05 else 0.0
    sides = [(-along, -1.0), (along, 1.0), (along, -1.0), (-along, 1.0)]
    for x, side in sides if along else [(0.0, -1.0), (0.0, 1.0)]:
        yield from _pulled_out(draft, own, mesh, x, side, own.half_depth + float(half_depth))
    turned = Footprint(own.x, own.y, own.half_depth, own.half_width, own.yaw + math.pi / 2)
    for side in (-1.0, 1.0):
        yield from _pulled_out(
            draft, turned, mesh, 0.0, side, turned.half_depth + float(half_depth)
        )


def _pulled_out(
    draft: Draft, own: Footprint, mesh: Mesh, x: float, side: float, touching: float
) -> Iterator[Float64]:
    tuck = float(draft.rng.uniform(0.08, 0.25))
    turn = float(draft.rng.normal(0, 0.1)) + (math.pi if side < 0 else 0.0)
    for distance in np.arange(touching - tuck, touching + 0.2, TUCK_STEP_M):
        yield _at(own, x, side * float(distance), mesh, turn)


def _aside(draft: Draft, host: Thing, mesh: Mesh, gap_m: float) -> Iterator[Float64]:
    """Yield places left and right of what stands ahead, turned towards it."""
    own = footprint(host.mesh, host.T_world_thing)
    low, high = bounds(mesh)
    half_depth = float(high[1] - low[1]) / 2
    sides = [1.0, -1.0] if draft.rng.random() < 0.5 else [-1.0, 1.0]
    for out in (0.5, 0.75, 1.0):
        for side in sides:
            for ahead in (0.7, 0.95, 1.2):
                turn = -side * math.pi / 2 * float(draft.rng.uniform(0.75, 1.0))
                x = side * (out + half_depth + gap_m)
                yield _at(own, x, -(own.half_depth + ahead), mesh, turn)


def _across(draft: Draft, host: Thing, mesh: Mesh, gap_m: float) -> Iterator[Float64]:
    """Yield places at the opposite wall, face to face."""
    wall = draft.wall_of.get(host.id)
    if wall is None:
        return
    opposite = draft.walls[(wall.side + 2) % 4]
    own = footprint(host.mesh, host.T_world_thing)
    along = opposite.along(own.x, own.y)
    for shift in (0.0, 0.15, -0.15, 0.3, -0.3, 0.5, -0.5, 0.7, -0.7):
        yield backed(mesh, opposite, along + shift)


def _at(own: Footprint, x: float, y: float, mesh: Mesh, turn: float) -> Float64:
    """Return the pose that puts a mesh's middle at a point in a host's own axes."""
    low, high = bounds(mesh)
    centre_x, centre_y = own.at(x, y)
    T_world = pose(centre_x, centre_y, 0.0, own.yaw + turn)
    T_world[:2, 3] -= T_world[:2, :2] @ ((low + high) / 2)[:2]
    return T_world


FINDERS: dict[str, Places] = {
    "beside": _beside,
    "ahead": _ahead,
    "tucked": _tucked,
    "around": _around,
    "aside": _aside,
    "across": _across,
}
"""How the places near a piece of furniture are found, by the word of ``Near.where``."""
