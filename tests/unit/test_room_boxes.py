import numpy as np
import pytest

from sceneq_tools.room.truth.boxes import (
    covered_share,
    gap,
    height_gap,
    level_gap,
    oriented_box,
    outline,
    world_box,
)

from support.boxed_room import placed, thing


def cube(x: float, y: float, z: float = 0.0, yaw: float = 0.0, size=(1.0, 1.0, 1.0)):
    return thing(9, "cube", "top", size, placed(x, y, z, yaw))


def test_the_box_is_that_of_the_turned_vertices() -> None:
    turned = cube(2, 3, 0.5, np.pi / 4, (2.0, 1.0, 0.4))
    reach = 1.5 / np.sqrt(2)
    expected = [[2 - reach, 3 - reach, 0.5], [2 + reach, 3 + reach, 0.9]]
    np.testing.assert_allclose(world_box(turned), expected, atol=1e-6)


def test_vertices_of_no_face_do_not_count() -> None:
    from dataclasses import replace

    whole = cube(0, 0)
    stray = np.vstack([whole.mesh.vertices, [[50, 50, 50]]]).astype(np.float32)
    np.testing.assert_allclose(
        world_box(replace(whole, mesh=replace(whole.mesh, vertices=stray))), world_box(whole)
    )


def test_the_oriented_box_turns_with_the_thing() -> None:
    box = oriented_box(cube(2, 3, 0.5, np.pi / 6, (2.0, 1.0, 0.4)))
    np.testing.assert_allclose(box.size, [2.0, 1.0, 0.4], atol=1e-6)
    np.testing.assert_allclose(box.centre, [2, 3, 0.7], atol=1e-6)
    np.testing.assert_allclose(box.axes[:, 0], [np.cos(np.pi / 6), 0.5, 0], atol=1e-6)


def test_gaps_of_turned_things_are_those_of_their_outlines() -> None:
    a, b = outline(cube(0, 0)), outline(cube(2, 0, yaw=np.pi / 4))
    assert level_gap(a, b) == pytest.approx(2 - 0.5 - np.sqrt(0.5), abs=1e-6)
    assert level_gap(a, b) == pytest.approx(level_gap(b, a))
    assert level_gap(a, outline(cube(0.4, 0))) == 0


def test_a_thing_in_the_air_is_apart_in_both_ways() -> None:
    a, b = outline(cube(0, 0)), outline(cube(4, 0, 5))
    assert (level_gap(a, b), height_gap(a, b)) == pytest.approx((3, 4), abs=1e-6)
    assert gap(a, b) == pytest.approx(5, abs=1e-6)


def test_the_covered_share_is_that_of_the_first_outline() -> None:
    small, large = outline(cube(0.5, 0)), outline(cube(0, 0, size=(1.0, 4.0, 1.0)))
    assert covered_share(small, large) == pytest.approx(0.5, abs=1e-5)
    assert covered_share(large, small) == pytest.approx(0.125, abs=1e-5)
