"""Triangulation of polygons and normals of what has none."""

import numpy as np
import pytest

from sceneq_tools.room.models.normals import crease_normals
from sceneq_tools.room.models.polygons import triangulated

ARROW = [(0, 0), (4, 2), (0, 4), (1, 2)]
COMB = [(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (0, 1)]


def area(points, triangles):
    corners = points[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return across.sum(axis=0) / 2, np.linalg.norm(across, axis=1).sum() / 2


@pytest.mark.parametrize("outline", [ARROW, ARROW[::-1], ARROW[1:] + ARROW[:1], COMB, COMB[::-1]])
@pytest.mark.parametrize("axes", [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_concave_polygons_are_covered_once(outline, axes):
    points = np.column_stack([np.array(outline, float), np.zeros(len(outline))])[:, axes]
    triangles, face = triangulated(points, np.array([len(outline)]))
    assert len(triangles) == len(outline) - 2
    assert set(face) == {0}
    signed, total = area(points, triangles)
    assert np.linalg.norm(signed) == pytest.approx(total), "no triangle folds back over another"


def test_faces_of_different_size_keep_their_order():
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    points = np.concatenate([square, square[:3], square])
    triangles, face = triangulated(points, np.array([4, 3, 4]))
    assert face.tolist() == [0, 0, 1, 2, 2]
    assert triangles[2].tolist() == [4, 5, 6]


def folded(degrees):
    """Two triangles that share an edge along x, the second bent upwards."""
    bend = np.deg2rad(degrees)
    points = np.array(
        [(0, 0, 0), (1, 0, 0), (0.5, -1, 0), (0.5, np.cos(bend), np.sin(bend))], dtype=float
    )
    return points, np.array([(0, 2, 1), (0, 1, 3)])


def test_gentle_bends_are_smooth_and_edges_sharp():
    gentle = crease_normals(*folded(20), smooth=np.array([True, True]))
    np.testing.assert_allclose(gentle[0, 0], gentle[1, 0])
    sharp = crease_normals(*folded(80), smooth=np.array([True, True]))
    np.testing.assert_allclose(sharp[0], [[0, 0, 1]] * 3)


def test_flat_faces_stay_flat():
    flat = crease_normals(*folded(20), smooth=np.array([False, False]))
    np.testing.assert_allclose(flat[0], [[0, 0, 1]] * 3)
