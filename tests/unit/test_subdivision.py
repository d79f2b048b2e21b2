import numpy as np
import pytest

from sceneq_tools.room.light.sample_points import distinct_places, sample_points
from sceneq_tools.room.light.subdivision import subdivided

from support.tiny_room import cube, sheet


def area(mesh) -> float:
    corners = mesh.vertices[mesh.faces]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return float(np.linalg.norm(cross, axis=1).sum() / 2)


def test_no_edge_stays_long_and_no_area_is_lost() -> None:
    fine = subdivided(sheet((0, 0, 0), (1, 0, 0), (0, 2, 0)), 0.1)

    corners = fine.vertices[fine.faces]
    assert np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2).max() <= 0.1
    assert area(fine) == pytest.approx(2.0, rel=1e-5)
    np.testing.assert_allclose(fine.uv, fine.vertices[:, :2] / [1, 2], atol=1e-5)


def test_neighbours_share_the_new_vertices() -> None:
    fine = subdivided(sheet((0, 0, 0), (1, 0, 0), (0, 1, 0)), 0.3)

    assert len(np.unique(fine.vertices, axis=0)) == len(fine.vertices)


def test_a_short_mesh_is_left_as_it_is() -> None:
    mesh = cube(0.1)

    assert len(subdivided(mesh, 1.0).faces) == len(mesh.faces)


def test_a_length_must_be_positive() -> None:
    with pytest.raises(ValueError, match="longest_m"):
        subdivided(cube(0.1), 0.0)


def test_points_lie_on_the_surface_and_values_are_averages_of_them() -> None:
    mesh = subdivided(cube(0.5), 0.1)
    places, place_of_corner = distinct_places(mesh, 0.03)
    points = sample_points(mesh, 0.1, places)

    distance = np.abs(points.at.positions - [0, 0, 0.25]).max(axis=1)
    np.testing.assert_allclose(distance, 0.25, atol=1e-6)
    np.testing.assert_allclose(points.blend.sum(axis=1), 1, atol=1e-5)
    assert points.blend.shape == (len(places.positions), len(points.at.positions))
    assert place_of_corner.shape == mesh.faces.shape
    offset = points.at.positions[points.of_face] - mesh.vertices[mesh.faces].mean(axis=1)
    assert np.linalg.norm(offset, axis=1).max() < 0.1 * np.sqrt(3)


def test_of_two_layers_the_outer_one_is_measured() -> None:
    from support.tiny_room import joined

    back = sheet((0, 0, 0), (1, 0, 0), (0, 1, 0))
    front = sheet((0.1, 0.1, 0.002), (0.8, 0, 0), (0, 0.8, 0))
    mesh = subdivided(joined(back, front), 0.1)
    points = sample_points(mesh, 0.1, distinct_places(mesh, 0.03)[0])

    inner = (np.abs(points.at.positions[:, :2] - 0.5) < 0.3).all(axis=1)
    assert inner.sum() > 20
    np.testing.assert_allclose(points.at.positions[inner, 2], 0.002, atol=1e-6)
