"""From an OBJ file as written to a mesh in metres, upright, standing on its origin."""

from collections.abc import Callable

import numpy as np

from sceneq_core.arrays import Float64, Int64
from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.models.furniture_catalogue import CatalogueEntry
from sceneq_tools.room.models.mtl_file import ObjMaterial
from sceneq_tools.room.models.normals import crease_normals, unit_vectors
from sceneq_tools.room.models.obj_file import ObjFile
from sceneq_tools.room.models.polygons import triangulated

_LEAST_AREA_M2 = 1e-12
_LEAST_OPACITY = 0.02  # authors hide helper faces this way
_GREY_SPREAD = 0.02
_BLENDER_SPECULAR = 0.5  # what the exporter writes for every matt surface nobody touched

Textured = Callable[[ObjMaterial], Material]


def model_mesh(entry: CatalogueEntry, obj: ObjFile, materials: tuple[Material, ...]) -> Mesh:
    """Turn, scale and place a model as its catalogue entry says, and make triangles of it.

    Args:
        entry: with the size it should have.
        obj: y up, front towards +z once rotated.
        materials: one for each of ``obj.material_names``.

    Raises:
        ValueError: when no triangle is left.
    """
    solid = np.array([material.opacity > _LEAST_OPACITY for material in materials])
    points, turn = _placed(entry, obj)
    triangles, face = triangulated(points[obj.corners[:, 0]], obj.sizes)
    keep = solid[obj.material_index[face]] & (_areas(points, obj, triangles) > _LEAST_AREA_M2)
    triangles, face = triangles[keep], face[keep]
    if not len(triangles):
        raise ValueError("no visible triangle")
    normals = _corner_normals(points, obj, triangles, face, turn)
    return _welded(points, obj, triangles, normals, obj.material_index[face], materials)


def surface(material: ObjMaterial, picture: np.ndarray | None) -> Material:
    """How a material of an MTL file looks.

    A grey in front of a picture is what exporters write when nobody chose a colour (black even, in
    some files), so that the picture counts alone; a chosen colour tints its picture.
    """
    colour = material.colour
    if picture is not None and max(colour) - min(colour) <= _GREY_SPREAD:
        colour = (1.0, 1.0, 1.0)
    untouched = abs(material.specular - _BLENDER_SPECULAR) < 1e-3
    return Material(
        colour=colour,
        texture=picture,
        opacity=material.opacity,
        shine=0.1 if untouched else material.specular,
        gloss=max(material.exponent, 1.0),
    )


def _placed(entry: CatalogueEntry, obj: ObjFile) -> tuple[Float64, Float64]:
    """All points in our frame, and the matrix that their normals take."""
    rotation = np.eye(3) if entry.rotation is None else entry.rotation
    points = obj.positions @ rotation.T
    used = points[np.unique(obj.corners[:, 0])] if len(obj.corners) else np.zeros((1, 3))
    low, high = used.min(axis=0), used.max(axis=0)
    factor = np.array(entry.size_m) / np.maximum(high - low, 1e-9)
    origin = np.array([(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2])
    upright = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])  # y up, +z front -> z up, -y front
    return (points - origin) * factor @ upright.T, upright @ np.diag(1 / factor) @ rotation


def _areas(points: Float64, obj: ObjFile, triangles: Int64) -> Float64:
    corner = points[obj.corners[triangles, 0]]
    across = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    return np.asarray(np.linalg.norm(across, axis=1) / 2)


def _corner_normals(
    points: Float64, obj: ObjFile, triangles: Int64, face: Int64, turn: Float64
) -> Float64:
    """(M, 3, 3): those of the file where it has them, else smoothed ones."""
    written = obj.corners[triangles, 2]
    normals = np.zeros((len(triangles), 3, 3))
    if len(obj.normals):
        normals = np.where(
            (written >= 0)[..., None], unit_vectors(obj.normals @ turn.T)[written], 0
        )
    missing = ~np.any(normals, axis=2)
    if missing.any():
        computed = crease_normals(points, obj.corners[triangles, 0], obj.smooth[face])
        normals[missing] = computed[missing]
    return normals


def _welded(
    points: Float64,
    obj: ObjFile,
    triangles: Int64,
    normals: Float64,
    material_index: Int64,
    materials: tuple[Material, ...],
) -> Mesh:
    """Corners that agree in place, texture coordinates and normal become one vertex."""
    corners = obj.corners[triangles.reshape(-1)]
    normals = normals.reshape(-1, 3)
    steps = np.round((normals + 1) * 500).astype(np.int64) @ np.array([1 << 20, 1 << 10, 1])
    _, place = np.unique(corners[:, 0] * (len(obj.uv) + 1) + corners[:, 1] + 1, return_inverse=True)
    _, first, inverse = np.unique(
        place.reshape(-1) * (1 << 31) + steps, return_index=True, return_inverse=True
    )
    kept = corners[first]
    textured = np.concatenate([obj.uv, np.zeros((1, 2))])[kept[:, 1]]  # -1 finds the zero
    used, material_index = np.unique(material_index, return_inverse=True)
    return Mesh(
        vertices=points[kept[:, 0]].astype(np.float32),
        normals=normals[first].astype(np.float32),
        uv=textured.astype(np.float32),
        faces=inverse.reshape(-1, 3).astype(np.int32),
        material_index=material_index.reshape(-1).astype(np.int32),
        materials=tuple(materials[int(i)] for i in used),
    )
