"""Triangles from polygons: fans for convex ones, ear clipping for the others."""

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64

Point = tuple[float, float]
Triple = tuple[int, int, int]
_BENT = 1e-9  # of the squared size of the polygon: less is a straight edge, not a dent
_QUAD_CUTS = np.array([[(0, 1, 2), (0, 2, 3)], [(0, 1, 3), (1, 2, 3)]], dtype=np.int64)


def triangulated(corner_points: Float64, sizes: Int64) -> tuple[Int64, Int64]:
    """Cut faces into triangles.

    Args:
        corner_points: (C, 3) positions of all faces' corners one after another.
        sizes: (F,) corners of each face, at least 3.

    Returns:
        (M, 3) indices into the corners and (M,) the face of each triangle, in the faces' order.
    """
    starts = np.concatenate([[0], np.cumsum(sizes)[:-1]]).astype(np.int64)
    triangles, faces = [], []
    for size in np.unique(sizes):
        of_size = np.flatnonzero(sizes == size)
        local, owner = _of_one_size(corner_points, starts[of_size], int(size))
        triangles.append(local)
        faces.append(of_size[owner])
    if not triangles:
        return np.zeros((0, 3), np.int64), np.zeros(0, np.int64)
    face = np.concatenate(faces)
    order = np.argsort(face, kind="stable")
    return np.concatenate(triangles)[order], face[order]


def _of_one_size(points: Float64, starts: Int64, size: int) -> tuple[Int64, Int64]:
    fan = np.array([(0, i, i + 1) for i in range(1, size - 1)], dtype=np.int64)
    polygons = points[starts[:, None] + np.arange(size)]
    normals = _newell(polygons)
    convex = _is_convex(polygons, normals) if size > 3 else np.ones(len(starts), dtype=bool)
    fans = (starts[convex, None, None] + fan).reshape(-1, 3)
    owners = np.repeat(np.flatnonzero(convex), size - 2)
    dented = np.flatnonzero(~convex)
    if size == 4:
        rest = _cut_quads(polygons[dented], normals[dented]) + starts[dented, None, None]
        return np.concatenate([fans, rest.reshape(-1, 3)]), np.append(owners, np.repeat(dented, 2))
    clipped = [np.array(ear_clip(polygons[i], normals[i])) + starts[i] for i in dented]
    return np.concatenate([fans, *clipped]), np.append(owners, np.repeat(dented, size - 2))


def _cut_quads(quads: Float64, normals: Float64) -> Int64:
    """Cut concave (n, 4, 3) along the diagonal that leaves both halves facing forward."""
    worst = []
    for cut in _QUAD_CUTS:
        a, b, c = (quads[:, cut[:, corner]] for corner in range(3))
        facing = (np.cross(b - a, c - a) * normals[:, None]).sum(axis=2)
        worst.append(facing.min(axis=1))
    return np.asarray(_QUAD_CUTS[np.argmax(worst, axis=0)])


def _newell(polygons: Float64) -> Float64:
    """Area vectors (n, 3), right for concave polygons too (Newell's method)."""
    return np.asarray(np.cross(polygons, np.roll(polygons, -1, axis=1)).sum(axis=1) / 2)


def _is_convex(polygons: Float64, normals: Float64) -> Bool:
    ahead = np.roll(polygons, -1, axis=1) - polygons
    turns = np.cross(ahead, np.roll(ahead, -1, axis=1))
    along = (turns * normals[:, None]).sum(axis=2)
    limit = _BENT * (normals**2).sum(axis=1)
    return np.asarray((along >= -limit[:, None]).all(axis=1))


def ear_clip(polygon: Float64, normal: Float64) -> list[Triple]:
    """Cut one polygon (k, 3) with area vector ``normal``; ears are taken in the corners' order.

    A polygon that crosses itself runs out of ears; the rest becomes a fan.
    """
    flat = _projected(polygon, normal)
    left = list(range(len(flat)))
    triples: list[Triple] = []
    while len(left) > 3:
        ear = next((at for at in range(len(left)) if _is_ear(flat, left, at)), None)
        if ear is None:
            break
        triples.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    return triples + [(left[0], left[i], left[i + 1]) for i in range(1, len(left) - 1)]


def _projected(polygon: Float64, normal: Float64) -> list[Point]:
    """Along the axis the polygon faces most, mirrored where needed so that it runs left."""
    drop = int(np.argmax(np.abs(normal)))
    first, second = (drop + 1) % 3, (drop + 2) % 3
    sign = 1.0 if normal[drop] >= 0 else -1.0
    return [(float(p[first]), sign * float(p[second])) for p in polygon]


def _is_ear(flat: list[Point], left: list[int], at: int) -> bool:
    a, b, c = flat[left[at - 1]], flat[left[at]], flat[left[(at + 1) % len(left)]]
    if _turn(a, b, c) <= 0:
        return False
    others = (flat[i] for i in left)
    return not any(p not in (a, b, c) and _inside(p, a, b, c) for p in others)


def _inside(p: Point, a: Point, b: Point, c: Point) -> bool:
    return _turn(a, b, p) >= 0 and _turn(b, c, p) >= 0 and _turn(c, a, p) >= 0


def _turn(a: Point, b: Point, c: Point) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
