"""A room with its light: made once, then kept up to date when things move."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int32
from sceneq_tools.room.light.illumination import (
    Illumination,
    PlaceLight,
    at_places,
    dark,
)
from sceneq_tools.room.light.light_mesh import LightMesh
from sceneq_tools.room.light.light_meter import LightMeter, Stale, everything
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.light.raycaster import Raycaster, TriangleGroup
from sceneq_tools.room.light.stage import Points, Stage, kept_things, stage
from sceneq_tools.room.room import Light, Room

NEAR_M = 0.5  # indirect light is measured anew this far around what changed, and twice its size
TOUCH_M = 0.05  # gaps are looked for anew this far around it
MARGIN_M = 0.001
OVERLAY_SHARE = 0.25  # with more new triangles than this the acceleration structure is rebuilt


@dataclass(frozen=True, slots=True, eq=False)
class Base:
    """Acceleration structures and the stage whose faces they count."""

    stage: Stage
    solid: TriangleGroup
    visible: TriangleGroup


@dataclass(frozen=True, slots=True, eq=False)
class LitRoom:
    """Everything a picture needs to know about a room.

    Attributes:
        light: at the sample points; ``place_light``: spread over all places.
        base: what was built when most of the room was new.
    """

    room: Room
    stage: Stage
    raycaster: Raycaster
    light: Illumination
    place_light: PlaceLight
    base: Base


def lit(room: Room, meshes: Sequence[LightMesh], quality: Quality) -> LitRoom:
    """Measure the light of a whole room."""
    whole = stage(room.things, meshes)
    base = _base(whole)
    raycaster = Raycaster((base.solid,), (base.visible,))
    light = dark(whole, len(room.lights))
    stale = everything(light)
    LightMeter(whole, room.lights, raycaster, quality, room.seed).measure(light, stale)
    return LitRoom(room, whole, raycaster, light, at_places(light, whole, room.lights), base)


def relit(old: LitRoom, room: Room, meshes: Sequence[LightMesh], quality: Quality) -> LitRoom:
    """Measure the light only on what changed, in its old and new shadow, and near it."""
    whole = stage(room.things, meshes, old.stage)
    base, raycaster = _over(old.base, whole)
    light, stale = _carried(old, whole, room.lights)
    changed = _changed(old.stage, whole)
    stale.fine[:] |= _near(whole.fine, changed, 1, TOUCH_M)
    stale.coarse[:] |= _near(whole.coarse, changed, 2, NEAR_M)
    for k, lamp in enumerate(room.lights):
        stale.direct[:, k] |= stale.fine | _shadowed(whole.fine, lamp, changed)
    LightMeter(whole, room.lights, raycaster, quality, room.seed).measure(light, stale)
    return LitRoom(room, whole, raycaster, light, at_places(light, whole, room.lights), base)


def _base(whole: Stage) -> Base:
    return Base(whole, *_groups(whole, np.ones(len(whole.faces), bool)))


def _groups(whole: Stage, chosen: Bool) -> list[TriangleGroup]:
    """Return the chosen faces that are solid, and all that are chosen."""
    kinds = (np.flatnonzero(kind).astype(np.int32) for kind in (chosen & ~whole.clear, chosen))
    return [TriangleGroup(whole.vertices, whole.faces[faces], faces) for faces in kinds]


def _over(base: Base, whole: Stage) -> tuple[Base, Raycaster]:
    """Return rays for the new stage: old triangles renumbered, new ones laid over them."""
    face_now, new = _face_numbers(base.stage, whole)
    if new.sum() > OVERLAY_SHARE * len(new):
        rebuilt = _base(whole)
        return rebuilt, Raycaster((rebuilt.solid,), (rebuilt.visible,))
    solid, visible = (g.renumbered(face_now[g.built_of]) for g in (base.solid, base.visible))
    over = _groups(whole, new | _touching(whole, base.stage))
    return base, Raycaster((solid, over[0]), (visible, over[1]))


def _face_numbers(before: Stage, after: Stage) -> tuple[Int32, Bool]:
    """Return for each old face its new number or -1, and which new faces have no old one."""
    now = np.full(len(before.faces), -1, np.int32)
    new = np.ones(len(after.faces), bool)
    for old_row, row in kept_things(before, after.things):
        first, last = after.face_starts[row : row + 2]
        start = before.face_starts[old_row]
        now[start : start + last - first] = np.arange(first, last)
        new[first:last] = False
    return now, new


def _touching(whole: Stage, base: Stage) -> Bool:
    """Return which faces may touch a thing of the base that is gone.

    A ray that is led on behind a gone book would start below the table top it lay on; so the top's
    faces are laid over the base as well.
    """
    touching = np.zeros(len(whole.faces), bool)
    kept = {row for row, _ in kept_things(base, whole.things)}
    for gone in set(range(len(base.things))) - kept:
        low, high = _bounds(base, gone)
        for row in range(len(whole.things)):
            lowest, highest = _bounds(whole, row)
            if (lowest <= high).all() and (highest >= low).all():
                faces = slice(whole.face_starts[row], whole.face_starts[row + 1])
                corners = whole.vertices[whole.faces[faces]]
                above, below = corners.min(axis=1) <= high, corners.max(axis=1) >= low
                touching[faces] |= (above & below).all(axis=1)
    return touching


def _bounds(whole: Stage, row: int) -> tuple[Float64, Float64]:
    """Return the corners of a thing's box, a millimetre wider than it is."""
    points = whole.vertices[whole.vertex_starts[row] : whole.vertex_starts[row + 1]]
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    return low - MARGIN_M, high + MARGIN_M


def _carried(old: LitRoom, whole: Stage, lights: Sequence[Light]) -> tuple[Illumination, Stale]:
    """Return the light that is still known, and where it is not."""
    light = dark(whole, len(lights))
    stale = everything(light)
    columns = _same_lights(old.room.lights, lights)
    for old_row, row in kept_things(old.stage, whole.things):
        source, target = _span(old.stage.fine, old_row), _span(whole.fine, row)
        light.open_fine[:, target] = old.light.open_fine[:, source]
        stale.fine[target] = False
        for before, after in columns:
            light.form[:, target, after] = old.light.form[:, source, before]
            light.seen[:, target, after] = old.light.seen[:, source, before]
            stale.direct[target, after] = False
        source, target = _span(old.stage.coarse, old_row), _span(whole.coarse, row)
        light.open_coarse[:, target] = old.light.open_coarse[:, source]
        light.indirect[:, target] = old.light.indirect[:, source]
        stale.coarse[target] = not len(columns) == len(lights) == len(old.room.lights)
    return light, stale


def _span(points: Points, row: int) -> slice:
    return slice(points.starts[row], points.starts[row + 1])


def _same_lights(before: Sequence[Light], after: Sequence[Light]) -> list[tuple[int, int]]:
    keys = [_light_key(light) for light in before]
    return [
        (keys.index(_light_key(light)), k)
        for k, light in enumerate(after)
        if _light_key(light) in keys
    ]


def _light_key(light: Light) -> tuple[float, ...]:
    return (*light.corner, *light.edge_u, *light.edge_v, *light.radiance)


def _changed(before: Stage, after: Stage) -> list[tuple[Float64, float]]:
    """Return the bounding sphere of everything that went or came: centre, radius."""
    pairs = kept_things(before, after.things)
    gone = set(range(len(before.things))) - {a for a, _ in pairs}
    come = set(range(len(after.things))) - {b for _, b in pairs}
    return [_sphere(before, row) for row in sorted(gone)] + [
        _sphere(after, row) for row in sorted(come)
    ]


def _sphere(whole: Stage, row: int) -> tuple[Float64, float]:
    points = whole.vertices[whole.vertex_starts[row] : whole.vertex_starts[row + 1]]
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    return (low + high) / 2, float(np.linalg.norm(high - low)) / 2


def _shadowed(points: Points, light: Light, spheres: list[tuple[Float64, float]]) -> Bool:
    """Return which points see some of the light past (or through) a sphere.

    The cone from the point to the light's bounding sphere is tested against each sphere.
    """
    middle = light.corner + (light.edge_u + light.edge_v) / 2
    spread = float(np.linalg.norm(light.edge_u) + np.linalg.norm(light.edge_v)) / 2
    axis = (middle - points.positions).astype(np.float32)
    squared = np.maximum(np.einsum("ij,ij->i", axis, axis), np.float32(1e-6))
    touched = np.zeros(len(axis), bool)
    for centre, radius in spheres:
        off = (centre - points.positions).astype(np.float32)
        along = np.clip(np.einsum("ij,ij->i", off, axis) / squared, 0, 1)
        distance = np.linalg.norm(off - along[:, None] * axis, axis=1)
        touched |= distance <= radius + along * spread
    return touched


def _near(
    points: Points, spheres: list[tuple[Float64, float]], sizes: float, margin_m: float
) -> Bool:
    """Return which points lie within ``sizes`` radii and a margin of a sphere."""
    near = np.zeros(len(points.positions), bool)
    for centre, radius in spheres:
        distance = np.linalg.norm(points.positions - centre, axis=1)
        near |= distance <= sizes * radius + margin_m
    return near
