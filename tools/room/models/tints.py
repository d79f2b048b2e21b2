"""Paint: the same model in different colours."""

from dataclasses import replace

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.mesh import Colour, Material, Mesh

TINTS: dict[str, Colour] = {
    "red": (0.76, 0.10, 0.09),
    "orange": (0.93, 0.48, 0.10),
    "yellow": (0.95, 0.80, 0.16),
    "green": (0.16, 0.50, 0.22),
    "blue": (0.13, 0.30, 0.68),
    "purple": (0.43, 0.20, 0.56),
    "pink": (0.94, 0.55, 0.66),
    "brown": (0.42, 0.26, 0.15),
    "white": (0.92, 0.92, 0.90),
    "gray": (0.50, 0.51, 0.53),
    "black": (0.09, 0.09, 0.10),
}
"""Names of paints and their sRGB colours."""

_LEAST_SHARE = 0.4  # of the surface: less paint than this does not make a red mug
_SAME_COLOUR = 0.02


def tinted(mesh: Mesh, tint: str) -> Mesh:
    """Paint the largest plain, solid material and those of the very same colour.

    Raises:
        ValueError: no such tint, or no plain surface that is large enough.
    """
    if tint not in TINTS:
        raise ValueError(f"no tint {tint!r}; there are {', '.join(TINTS)}")
    areas = _areas_m2(mesh)
    plain = [i for i, material in enumerate(mesh.materials) if _is_plain(material)]
    if not plain:
        raise ValueError("every surface has a picture or is glass: it cannot be tinted")
    main = mesh.materials[max(plain, key=lambda i: areas[i])].colour
    painted = [i for i in plain if _is_same(mesh.materials[i].colour, main)]
    if areas[painted].sum() < _LEAST_SHARE * areas.sum():
        share = 100 * areas[painted].sum() / areas.sum()
        raise ValueError(f"only {share:.0f} % of the surface is plain: it cannot be tinted")
    return replace(mesh, materials=_repainted(mesh.materials, painted, TINTS[tint]))


def _repainted(
    materials: tuple[Material, ...], which: list[int], colour: Colour
) -> tuple[Material, ...]:
    return tuple(
        replace(material, colour=colour) if i in which else material
        for i, material in enumerate(materials)
    )


def _is_plain(material: Material) -> bool:
    return material.texture is None and material.opacity >= 0.5 and material.emission == 0


def _is_same(a: Colour, b: Colour) -> bool:
    return max(abs(x - y) for x, y in zip(a, b, strict=True)) <= _SAME_COLOUR


def _areas_m2(mesh: Mesh) -> Float64:
    corners = mesh.vertices[mesh.faces].astype(np.float64)
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    areas = np.bincount(mesh.material_index, area / 2, minlength=len(mesh.materials))
    return areas.astype(np.float64)
