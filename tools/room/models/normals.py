"""Normals for models that come without: smooth over gentle bends, sharp at edges."""

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64

_STEPS = (1 << 20) - 2  # per axis: points that agree to a millionth of the model are the same


def crease_normals(
    points: Float64, triangles: Int64, smooth: Bool, crease_deg: float = 45.0
) -> Float64:
    """Return a normal for each corner of each triangle.

    Args:
        points: (V, 3); points at the same place count as one, whatever their index.
        triangles: (M, 3) into the points.
        smooth: (M,) false where the triangle keeps its flat normal.
        crease_deg: triangles that meet at more than this angle do not smooth each other.

    Returns:
        (M, 3, 3) unit normals; zero for triangles without area.
    """
    corners = points[triangles]
    area = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    unit = unit_vectors(area)
    normals = np.repeat(unit[:, None], 3, axis=1)
    curved = np.flatnonzero(smooth)
    if not len(curved):
        return normals
    rows, columns = _pairs(_places(points)[triangles[curved]].reshape(-1))
    row_face, column_face = curved[rows // 3], curved[columns // 3]
    turn = np.einsum("ij,ij->i", unit[row_face], unit[column_face])
    close = turn >= np.cos(np.deg2rad(crease_deg))
    rows, added = rows[close], area[column_face[close]]
    sums = [np.bincount(rows, added[:, axis], minlength=3 * len(curved)) for axis in range(3)]
    normals[curved] = unit_vectors(np.stack(sums, axis=1)).reshape(-1, 3, 3)
    return normals


def unit_vectors(vectors: Float64) -> Float64:
    """Scale to length 1; vectors without length stay zero."""
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))[..., None]
    return np.asarray(np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0))


def _places(points: Float64) -> Int64:
    """One number for each place in space (V,)."""
    low = points.min(axis=0)
    cell = np.maximum((points.max(axis=0) - low).max(), 1e-12) / _STEPS
    grid = np.round((points - low) / cell).astype(np.int64)
    return np.asarray(grid @ np.array([1 << 40, 1 << 20, 1]))


def _pairs(group: Int64) -> tuple[Int64, Int64]:
    """All ordered pairs of positions that carry the same group number, each with itself too."""
    order = np.argsort(group, kind="stable")
    starts = np.flatnonzero(np.diff(group[order], prepend=group[order][:1] - 1))
    count = np.diff(starts, append=len(group))
    partners = np.repeat(count, count)
    first = np.cumsum(partners) - partners
    start_of = np.repeat(starts, count) - first
    columns = np.arange(int(partners.sum())) + np.repeat(start_of, partners)
    return np.repeat(order, partners), order[columns]
