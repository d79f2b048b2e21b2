"""Pictures of point clouds."""

import numpy as np
import pytest

from sceneq_core.picture import instance_colours
from sceneq_core.picture.colours import MARK_COLOURS, dimmed, quieted
from sceneq_core.picture.cutaway import below_ceiling, open_towards, without_specks
from sceneq_core.picture.lettering import text_size, write
from sceneq_core.picture.projection import from_above, from_corner, room_axes
from sceneq_core.picture.splats import BACKGROUND, FINER, ids_seen, shaded, splat

from support.furnished_cloud import CEILING, FLOOR, UP_Z, VOXEL_M, WALL, cloud, grid, room_points

ROLLED = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
"""A world whose y points down, as that of many hand-held cameras."""


def turned(angle_deg: float) -> np.ndarray:
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def test_instances_differ_in_colour_and_unassigned_points_are_grey() -> None:
    ids = np.arange(0, 50, dtype=np.int32)
    colours = instance_colours(ids, np.full((50, 3), 128, np.uint8))
    assert np.ptp(colours[0]) == 0
    assert len(np.unique(colours, axis=0)) == 50


def test_walls_are_paler_than_things_and_faint_things_paler_still() -> None:
    colours = instance_colours(np.arange(1, 20, dtype=np.int32), np.full((19, 3), 128, np.uint8))
    quiet = quieted(colours, np.ones(19, np.bool_))
    assert (np.ptp(quiet, axis=1) < np.ptp(colours, axis=1)).all()
    assert (quieted(colours, np.zeros(19, np.bool_)) == colours).all()
    assert (dimmed(colours).mean(axis=1) > colours.mean(axis=1)).all()


@pytest.mark.parametrize("R_world_room", [np.eye(3), ROLLED, ROLLED @ turned(20.0), turned(-33.0)])
def test_the_axes_of_a_room_are_its_up_and_its_walls(R_world_room: np.ndarray) -> None:
    scene = cloud(R_world_room)
    R_room_world = room_axes(scene.points_world, scene.up_world)
    assert np.allclose(R_room_world @ R_room_world.T, np.eye(3))
    assert np.linalg.det(R_room_world) == pytest.approx(1.0)
    assert np.allclose(R_room_world @ scene.up_world, [0, 0, 1])
    along_walls = np.abs(R_room_world @ R_world_room)
    assert np.allclose(along_walls.max(axis=1), 1.0, atol=2e-2)


def test_a_little_noise_in_up_does_not_turn_the_plan() -> None:
    points = cloud().points_world
    for noise in ((1e-3, 3e-4, 1.0), (3e-4, 1e-3, 1.0)):
        assert room_axes(points, np.array(noise))[0] @ [1, 0, 0] > 0.99


@pytest.mark.parametrize("R_world_room", [np.eye(3), ROLLED])
def test_up_is_up_in_the_corner_views_and_towards_the_eye_from_above(
    R_world_room: np.ndarray,
) -> None:
    scene = cloud(R_world_room)
    points = scene.points_world.astype(float)
    R_room_world = room_axes(scene.points_world, scene.up_world)
    low_high = np.array([[2.0, 1.5, 0.0], [2.0, 1.5, 1.0]]) @ R_world_room.T
    for azimuth in (-135.0, 45.0):
        pixels, depth_m = from_corner(points, R_room_world, azimuth, (300, 200)).project(low_high)
        assert pixels[1, 1] < pixels[0, 1] - 10
        assert depth_m[1] < depth_m[0]
    pixels, depth_m = from_above(points, R_room_world, (300, 200)).project(low_high)
    assert np.allclose(pixels[0], pixels[1], atol=1e-6)
    assert depth_m[1] == pytest.approx(depth_m[0] - 1.0)


def test_nearly_all_points_fall_into_the_picture() -> None:
    points = cloud().points_world.astype(float)
    R_room_world = room_axes(points.astype(np.float32), UP_Z)
    for view in (
        from_above(points, R_room_world, (300, 200)),
        from_corner(points, R_room_world, 45.0, (300, 200)),
    ):
        pixels, depth_m = view.project(points)
        assert (depth_m > 0).all()
        inside = ((pixels > 0) & (pixels < [300, 200])).all(axis=1)
        assert inside.mean() > 0.99  # the last few count as strays


def test_the_nearer_point_hides_the_farther_one_in_any_order() -> None:
    view = from_above(cloud().points_world.astype(float), np.eye(3), (300, 200))
    points = np.array([[2.0, 1.5, 1.0], [2.0, 1.5, 0.0]])
    for order in ([0, 1], [1, 0]):
        seen = splat(view, points[order], 0.05)
        ids = np.array([7, 8], np.int32)[order]
        (u, v), _ = (a[0] for a in view.project(points))
        assert ids_seen(seen, ids)[round(v), round(u)] == 7
        assert ids_seen(seen, ids)[0, 0] == -1
        image = shaded(seen, np.full((2, 3), 200, np.uint8), ids)
        assert tuple(image[0, 0]) == BACKGROUND


def test_a_surface_has_no_holes_even_where_every_other_point_is_missing() -> None:
    floor = grid((0, 0, 0), (2, 2, 0))
    sparse = floor[::2].astype(float)
    view = from_above(floor.astype(float), np.eye(3), (200, 200)).enlarged(FINER)
    point = splat(view, sparse, VOXEL_M).point
    middle = point[40:-40, 40:-40]
    assert (middle >= 0).all()


def test_the_ceiling_goes_but_a_lamp_under_it_stays() -> None:
    points, ids = room_points()
    lamp = np.array([[2.0, 1.5, 2.3]])
    shell = np.isin(np.append(ids, 99), [FLOOR, WALL, CEILING])
    kept = below_ceiling(np.concatenate([points, lamp]), shell)
    assert not kept[:-1][ids == CEILING].any()
    assert kept[:-1][ids == FLOOR].all()
    assert kept[-1]


def test_a_wall_goes_when_one_looks_from_behind_it_and_stays_when_not() -> None:
    points, ids = room_points()
    shell = np.isin(ids, [FLOOR, WALL, CEILING])
    back = (ids == WALL) & (points[:, 1] > 2.9) & (points[:, 2] > 0.5) & (points[:, 2] < 2)
    assert not open_towards(points, shell, 90.0)[back].any()
    assert open_towards(points, shell, -90.0)[back].all()
    assert open_towards(points, shell, 90.0)[~shell].all()
    assert open_towards(points, shell, 90.0)[ids == FLOOR].all()


def test_lonely_points_of_nothing_are_left_out() -> None:
    dense = grid((0, 0, 0), (0.4, 0.4, 0))
    points = np.concatenate([dense, [[1.0, 1.0, 1.0]]])
    kept = without_specks(points, np.ones(len(points), np.bool_))
    assert kept[-1] == np.False_
    assert kept[:-1].mean() > 0.5
    assert without_specks(points, np.zeros(len(points), np.bool_)).all()


def test_text_is_as_wide_as_measured_and_dark_on_its_place() -> None:
    image = np.full((40, 200, 3), 255, np.uint8)
    width, height = text_size("7 mug", 16)
    write(image, "7 mug", (10, 10), 16)
    v, u = np.nonzero(image.min(axis=2) < 128)
    assert u.min() >= 8
    assert u.max() <= 10 + width
    assert v.min() >= 10
    assert v.max() <= 10 + 1.2 * height
    assert MARK_COLOURS[0] != MARK_COLOURS[1]
