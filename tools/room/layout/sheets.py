"""Flat rectangles anywhere in space."""

import numpy as np
import numpy.typing as npt

from sceneq_tools.room.mesh import Material
from sceneq_tools.room.models.solids import Solid


def sheet(
    material: Material, corner: npt.ArrayLike, edge_u: npt.ArrayLike, edge_v: npt.ArrayLike
) -> Solid:
    """Return a rectangle that faces ``cross(edge_u, edge_v)``; texture coordinates in metres.

    Texture coordinates count from the corner's own position along the edges, so that the pattern
    runs on from one sheet of a wall to the next.
    """
    start, u, v = (np.asarray(edge, np.float64) for edge in (corner, edge_u, edge_v))
    normal = np.cross(u, v)
    vertices = np.stack([start, start + u, start + u + v, start + v])
    axes = np.stack([u / np.linalg.norm(u), v / np.linalg.norm(v)], axis=1)
    return Solid(
        vertices=vertices,
        normals=np.tile(normal / np.linalg.norm(normal), (4, 1)),
        uv=vertices @ axes,
        faces=np.array([[0, 1, 2], [0, 2, 3]]),
        material=material,
    )
