import numpy as np
import pytest

from sceneq_tools.room.light.raycaster import Raycaster, TriangleGroup

from support.tiny_room import joined, sheet


def group(*meshes) -> TriangleGroup:
    mesh = joined(*meshes)
    return TriangleGroup(mesh.vertices, mesh.faces, np.arange(len(mesh.faces), dtype=np.int32))


def plate(z: float):
    return sheet((-1, -1, z), (2, 0, 0), (0, 2, 0))


DOWN = np.array([[0.1, 0.2, 3.0]], np.float32), np.array([[0, 0, -2.0]], np.float32)
EMPTY = group(plate(0)).renumbered(np.array([-1, -1], np.int32))


def test_the_nearest_of_all_groups_is_met_and_distance_counts_in_directions() -> None:
    hits = Raycaster((), (group(plate(0.0)), group(plate(1.0)))).nearest(*DOWN)

    assert hits.distance[0] == pytest.approx(1.0)
    np.testing.assert_allclose(hits.normal[0], [0, 0, 1])


def test_only_solid_triangles_block_light() -> None:
    raycaster = Raycaster((group(plate(0.0)),), (group(plate(0.0), plate(1.0)),))

    assert raycaster.nearest(*DOWN).distance[0] == pytest.approx(1.0)
    assert raycaster.nearest_solid(*DOWN).distance[0] == pytest.approx(1.5)
    assert raycaster.occluded(*DOWN, reach=1.6).tolist() == [True]
    assert raycaster.occluded(*DOWN, reach=1.4).tolist() == [False]


def test_a_ray_goes_on_behind_what_is_gone() -> None:
    two = group(plate(0.0), plate(1.0)).renumbered(np.array([40, 41, -1, -1], np.int32))
    hits = Raycaster((two,), (two,)).nearest(*DOWN)

    assert hits.distance[0] == pytest.approx(1.5)
    assert hits.face[0] in (40, 41)
    assert Raycaster((two,), ()).occluded(*DOWN, reach=1.6).tolist() == [True]
    assert Raycaster((two,), ()).occluded(*DOWN, reach=1.4).tolist() == [False]


def test_a_room_of_which_nothing_is_left_is_empty() -> None:
    raycaster = Raycaster((EMPTY,), (EMPTY,))

    assert raycaster.nearest(*DOWN).face.tolist() == [-1]
    assert np.isinf(raycaster.nearest(*DOWN).distance).all()
    assert not raycaster.occluded(*DOWN).any()
