"""What shading reads at the corners of faces, packed so that one look fetches all of it.

Rows have 8 columns (32 bytes) where they can: numpy copies rows of that size at full speed.
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Int32, Int64
from sceneq_tools.room.light.illumination import PlaceLight
from sceneq_tools.room.light.stage import Stage

COLUMNS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Corners:
    """The faces that N rays meet.

    Attributes:
        vertex, place: int32 (N, 3) rows of tables.
        material: int64 (N,); ``texels_per_m``: float32 (N,).
    """

    vertex: Int32
    place: Int32
    material: Int64
    texels_per_m: Float32


@dataclass(frozen=True, slots=True, eq=False)
class CornerTables:
    """Tables by face, by vertex and by place.

    Attributes:
        faces: int32 (F, 8): three vertices, three places, material, and the bits of texels_per_m.
        vertices: float32 (V, 8): normal, texture coordinates.
        places: float32 (2 P, 8 or more): irradiance, share of each light that is seen; the fronts
            of all places, then their backs.
        lights: how many lights.
    """

    faces: Int32
    vertices: Float32
    places: Float32
    lights: int

    def corners(self, face: Int32, back: Int32) -> Corners:
        """Return what belongs to faces (N,); ``back`` is 1 where their backs are seen, else 0."""
        row = self.faces.take(face, axis=0)
        place = row[:, 3:6] + (back * np.int32(len(self.places) // 2))[:, None]
        texels_per_m = row[:, 7].copy().view(np.float32)
        return Corners(row[:, :3], place, row[:, 6].astype(np.int64), texels_per_m)

    def surface(self, corners: Corners, weights: Float32) -> tuple[Float32, Float32]:
        """Return normals (3, N), not of unit length, and texture coordinates (2, N)."""
        columns = _mixed(self.vertices, corners.vertex, weights)
        return columns[:3], columns[3:5]

    def light(self, corners: Corners, weights: Float32) -> tuple[Float32, Float32]:
        """Return irradiance (3, N) and the share that is seen of each light (L, N)."""
        columns = _mixed(self.places, corners.place, weights)
        return columns[:3], columns[3 : 3 + self.lights]


def corner_tables(stage: Stage, light: PlaceLight) -> CornerTables:
    """Pack what belongs to the faces, vertices and places of a stage."""
    faces = np.empty((len(stage.faces), COLUMNS), np.int32)
    faces[:, :3], faces[:, 3:6] = stage.faces, stage.place_of_corner
    faces[:, 6], faces[:, 7] = stage.material, stage.texels_per_m.view(np.int32)
    vertices = _packed(stage.normals, stage.uv)
    return CornerTables(faces, vertices, _packed(light.irradiance, light.seen), light.seen.shape[1])


def _packed(*parts: Float32) -> Float32:
    used = sum(part.shape[1] for part in parts)
    table = np.zeros((len(parts[0]), -(-used // COLUMNS) * COLUMNS), np.float32)
    table[:, :used] = np.hstack(parts)
    return table


def _mixed(table: Float32, corners: Int32, weights: Float32) -> Float32:
    """Return the columns (C, N) of ``table``'s rows at three corners, weighted."""
    mixed: Float32 = weights[0] * _columns(table, corners[:, 0])
    for corner in (1, 2):
        columns = _columns(table, corners[:, corner])
        columns *= weights[corner]
        mixed += columns
    return mixed


def _columns(table: Float32, rows: Int32) -> Float32:
    return np.ascontiguousarray(table.take(rows, axis=0).T)
