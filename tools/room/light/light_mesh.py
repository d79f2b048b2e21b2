"""A mesh made ready to be lit: fine enough, with the points where light is measured."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float32, Int32
from sceneq_tools.room.light.sample_points import SamplePoints, distinct_places, sample_points
from sceneq_tools.room.light.subdivision import subdivided
from sceneq_tools.room.light.texture_atlas import halvings
from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.textures.linear import linear

CELLS_ACROSS = 25  # cells along the diagonal of a thing: shadows on small things are small
FINEST_M = 0.012
COARSE = 2.5  # indirect light changes more slowly than shadows: this much larger cells
BRIGHTEST = 0.85  # no paint reflects more; without a limit a white room never gets dark
GLIMPSE_PX = 64  # texture size from which the mean colour of a face is read


@dataclass(frozen=True, slots=True, eq=False)
class LightMesh:
    """Geometry in the mesh's own frame that does not change while the thing is moved about.

    Attributes:
        mesh: subdivided, every face wound so that its normal agrees with its vertices'.
        fine: points for direct light; ``coarse``: points for indirect light.
        place_of_corner: int32 (F, 3) the place that ``blend`` gives the corner's light for.
        face_colour: float32 (F, 3) linear share of light that the face reflects.
        clear: bool (F,) light passes: glass, cut out, or glowing itself.
        texels_per_m: float32 (F,) resolution of the full texture on the face; 0 without one.
    """

    mesh: Mesh
    fine: SamplePoints
    coarse: SamplePoints
    place_of_corner: Int32
    face_colour: Float32
    clear: Bool
    texels_per_m: Float32


def light_mesh(mesh: Mesh, cell_m: float) -> LightMesh:
    """Prepare a mesh; ``cell_m`` is the coarsest distance of points on large things."""
    diagonal = float(np.linalg.norm(np.ptp(mesh.vertices, axis=0)))
    cell = float(np.clip(diagonal / CELLS_ACROSS, FINEST_M, cell_m))
    fine_mesh = subdivided(_consistent(mesh), 1.5 * cell)
    places, place_of_corner = distinct_places(fine_mesh, cell / 3)
    colour, alpha = _face_colours(fine_mesh)
    return LightMesh(
        fine_mesh,
        sample_points(fine_mesh, cell, places),
        sample_points(fine_mesh, COARSE * cell, places),
        place_of_corner,
        colour,
        _clear(fine_mesh, alpha),
        _texels_per_m(fine_mesh),
    )


def _consistent(mesh: Mesh) -> Mesh:
    """Turn faces whose winding contradicts their shading, and drop those without area."""
    corners = mesh.vertices[mesh.faces]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    turned = (flat * mesh.normals[mesh.faces].sum(axis=1)).sum(axis=1) < 0
    faces = np.where(turned[:, None], mesh.faces[:, [0, 2, 1]], mesh.faces)
    kept = np.linalg.norm(flat, axis=1) > 1e-12
    return Mesh(
        mesh.vertices,
        mesh.normals,
        mesh.uv,
        faces[kept].astype(np.int32),
        mesh.material_index[kept],
        mesh.materials,
    )


def _face_colours(mesh: Mesh) -> tuple[Float32, Float32]:
    """Return linear colour (F, 3) and alpha (F,) at the middle of each face."""
    colour = np.zeros((len(mesh.faces), 3), np.float32)
    alpha = np.ones(len(mesh.faces), np.float32)
    middle = mesh.uv[mesh.faces].mean(axis=1)
    for index, material in enumerate(mesh.materials):
        here = mesh.material_index == index
        colour[here] = linear(np.array(material.colour, np.float32))
        if material.texture is not None:
            texels = _texels(material, middle[here])
            colour[here] *= linear(texels[:, :3])
            alpha[here] = texels[:, 3]
    return np.clip(colour, 0, BRIGHTEST), alpha


def _texels(material: Material, uv: Float32) -> Float32:
    assert material.texture is not None
    small = next(h for h in halvings(material.texture, 1024) if max(h.shape[:2]) <= GLIMPSE_PX)
    h, w = small.shape[:2]
    at = uv - np.floor(uv)
    column = np.minimum((at[:, 0] * w).astype(np.int32), w - 1)
    row = np.minimum(((1 - at[:, 1]) * h).astype(np.int32), h - 1)
    texels: Float32 = small[row, column].astype(np.float32) / 255
    return texels


def _clear(mesh: Mesh, alpha: Float32) -> Bool:
    clear = [m.opacity < 1 or m.emission > 0 for m in mesh.materials]
    return np.array(clear, bool)[mesh.material_index] | (alpha < 0.5)


def _texels_per_m(mesh: Mesh) -> Float32:
    size = np.array([_texture_area(m) for m in mesh.materials], np.float32)
    corners, uv = mesh.vertices[mesh.faces], mesh.uv[mesh.faces]
    edges, steps = corners[:, 1:] - corners[:, :1], uv[:, 1:] - uv[:, :1]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    texels = np.abs(steps[:, 0, 0] * steps[:, 1, 1] - steps[:, 0, 1] * steps[:, 1, 0])
    density = np.sqrt(texels * size[mesh.material_index] / np.maximum(area, 1e-12))
    return np.asarray(density, np.float32)


def _texture_area(material: Material) -> int:
    return 0 if material.texture is None else int(np.prod(material.texture.shape[:2]))
