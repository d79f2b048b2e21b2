"""All things of a room in flat arrays, in the world's frame."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32, UInt16
from sceneq_tools.room.light.light_mesh import LightMesh
from sceneq_tools.room.light.sample_points import SamplePoints
from sceneq_tools.room.mesh import Material
from sceneq_tools.room.room import Thing


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Sample points of all things; those of thing k are ``starts[k]`` to ``starts[k + 1]``.

    Attributes:
        positions: float32 (P, 3) world, metres; ``normals``: float32 (P, 3).
        number: int32 (P,) of the point within its thing; ``thing_id``: int32 (P,).
        two_sided: bool (P,) whether the back may be seen too.
        starts: int32 (T + 1,).
    """

    positions: Float32
    normals: Float32
    number: Int32
    thing_id: Int32
    two_sided: Bool
    starts: Int32


@dataclass(frozen=True, slots=True, eq=False)
class Stage:
    """Everything that rays can meet.

    Attributes:
        things: in order; their faces are ``face_starts[k]`` to ``face_starts[k + 1]``.
        meshes: one for each thing.
        vertices: float32 (V, 3) world, metres.
        normals: float32 (V, 3); ``uv``: float32 (V, 2).
        faces: int32 (F, 3); ``material``: int32 (F,); ``thing_id``: uint16 (F,).
        face_colour, clear, texels_per_m: as in ``LightMesh``.
        place_of_corner: int32 (F, 3) row in the light of places; ``place_starts``: int32 (T + 1,).
        fine, coarse: the sample points; ``fine_of_face`` and ``coarse_of_face``: int32 (F,) the
            points that stand for each face.
        materials: the rows that ``material`` counts.
    """

    things: tuple[Thing, ...]
    meshes: tuple[LightMesh, ...]
    face_starts: Int32
    vertex_starts: Int32
    vertices: Float32
    normals: Float32
    uv: Float32
    faces: Int32
    material: Int32
    thing_id: UInt16
    face_colour: Float32
    clear: Bool
    texels_per_m: Float32
    place_of_corner: Int32
    place_starts: Int32
    fine: Points
    coarse: Points
    fine_of_face: Int32
    coarse_of_face: Int32
    materials: tuple[Material, ...]


def stage(
    things: Sequence[Thing], meshes: Sequence[LightMesh], before: Stage | None = None
) -> Stage:
    """Put the meshes in their places; what has not changed since ``before`` is taken from there."""
    kept = {} if before is None else {new: old for old, new in kept_things(before, things)}
    vertex_starts = ranges([len(s.mesh.vertices) for s in meshes])
    face_starts = ranges([len(s.mesh.faces) for s in meshes])
    place_starts = ranges([s.fine.blend.shape[0] for s in meshes])
    materials, material = _materials(meshes)
    pairs = list(enumerate(zip(things, meshes, strict=True)))
    fine = _points(things, [s.fine for s in meshes])
    coarse = _points(things, [s.coarse for s in meshes])
    return Stage(
        tuple(things),
        tuple(meshes),
        face_starts,
        vertex_starts,
        _joined([_vertices(k, t, s, kept, before) for k, (t, s) in pairs], 3),
        _joined([_normals(k, t, s, kept, before) for k, (t, s) in pairs], 3),
        _joined([s.mesh.uv for s in meshes], 2),
        _shifted([s.mesh.faces for s in meshes], vertex_starts).reshape(-1, 3),
        material,
        np.repeat([t.id for t in things], np.diff(face_starts)).astype(np.uint16),
        _joined([s.face_colour for s in meshes], 3),
        np.concatenate([np.zeros(0, bool), *(s.clear for s in meshes)]),
        np.concatenate([np.zeros(0, np.float32), *(s.texels_per_m for s in meshes)]),
        _shifted([s.place_of_corner for s in meshes], place_starts).reshape(-1, 3),
        place_starts,
        fine,
        coarse,
        _shifted([s.fine.of_face for s in meshes], fine.starts),
        _shifted([s.coarse.of_face for s in meshes], coarse.starts),
        materials,
    )


def kept_things(before: Stage, things: Sequence[Thing]) -> list[tuple[int, int]]:
    """Return (row in ``before``, row in ``things``) of things that did not change."""
    rows = {thing.id: row for row, thing in enumerate(before.things)}
    return [
        (rows[thing.id], row)
        for row, thing in enumerate(things)
        if thing.id in rows and _unchanged(before.things[rows[thing.id]], thing)
    ]


def _unchanged(before: Thing, after: Thing) -> bool:
    return before.mesh is after.mesh and bool(
        np.array_equal(before.T_world_thing, after.T_world_thing)
    )


def ranges(counts: list[int]) -> Int32:
    """Return where each of several arrays starts when they are put behind one another."""
    return np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)


def placed(thing: Thing, points: Float32) -> Float32:
    """Return points (N, 3) of the thing's own frame in the world's."""
    turned_only = points.astype(np.float64) @ thing.T_world_thing[:3, :3].T
    return (turned_only + thing.T_world_thing[:3, 3]).astype(np.float32)


def turned(thing: Thing, directions: Float32) -> Float32:
    """Return directions (N, 3) of the thing's own frame in the world's."""
    return (directions.astype(np.float64) @ thing.T_world_thing[:3, :3].T).astype(np.float32)


def _vertices(
    row: int, thing: Thing, mesh: LightMesh, kept: dict[int, int], before: Stage | None
) -> Float32:
    if before is None or row not in kept:
        return placed(thing, mesh.mesh.vertices)
    return before.vertices[_span(before, kept[row])]


def _normals(
    row: int, thing: Thing, mesh: LightMesh, kept: dict[int, int], before: Stage | None
) -> Float32:
    if before is None or row not in kept:
        return turned(thing, mesh.mesh.normals)
    return before.normals[_span(before, kept[row])]


def _span(before: Stage, row: int) -> slice:
    return slice(before.vertex_starts[row], before.vertex_starts[row + 1])


def _points(things: Sequence[Thing], samples: list[SamplePoints]) -> Points:
    counts = [len(s.at.positions) for s in samples]
    pairs = list(zip(things, samples, strict=True))
    return Points(
        _joined([placed(t, s.at.positions) for t, s in pairs], 3),
        _joined([turned(t, s.at.normals) for t, s in pairs], 3),
        np.concatenate([np.zeros(0, np.int32), *(np.arange(n, dtype=np.int32) for n in counts)]),
        np.repeat([t.id for t in things], counts).astype(np.int32),
        np.repeat([not t.is_stuff for t in things], counts).astype(bool),
        ranges(counts),
    )


def _materials(meshes: Sequence[LightMesh]) -> tuple[tuple[Material, ...], Int32]:
    """One row for each material object; shared ones once."""
    rows: dict[int, int] = {}
    materials: list[Material] = []
    indices = [np.zeros(0, np.int32)]
    for one in meshes:
        for material in one.mesh.materials:
            if id(material) not in rows:
                rows[id(material)] = len(materials)
                materials.append(material)
        local = np.array([rows[id(m)] for m in one.mesh.materials], np.int32)
        indices.append(local[one.mesh.material_index])
    return tuple(materials), np.concatenate(indices)


def _joined(parts: list[Float32], columns: int) -> Float32:
    joined: Float32 = np.concatenate([np.zeros((0, columns), np.float32), *parts])
    return joined


def _shifted(parts: list[Int32], starts: Int32) -> Int32:
    shifted = [part.reshape(-1) + start for part, start in zip(parts, starts, strict=False)]
    return np.concatenate([np.zeros(0, np.int32), *shifted]).astype(np.int32)
