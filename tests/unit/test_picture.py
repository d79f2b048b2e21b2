"""Pictures of point clouds."""

import numpy as np
import pytest

from sceneq_core.picture import BACKGROUND, draw_cloud, draw_labels, instance_colours, overview

UP = np.array([0.0, 0.0, 1.0])


def floor_and_wall() -> np.ndarray:
    x, y = np.meshgrid(np.arange(0, 2, 0.02), np.arange(0, 2, 0.02))
    floor = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    wall = np.stack([x.ravel(), np.full(x.size, 2.0), y.ravel()], axis=1)
    return np.concatenate([floor, wall]).astype(np.float32)


def test_the_camera_stands_above_and_on_the_open_side() -> None:
    viewpoint = overview(floor_and_wall(), UP)
    R_camera_world, t = viewpoint.T_camera_world[:3, :3], viewpoint.T_camera_world[:3, 3]
    position_world = -R_camera_world.T @ t
    assert position_world[2] > 1.0
    assert position_world[1] < 0.0


def test_all_points_fall_into_the_picture() -> None:
    points = floor_and_wall()
    pixels, depth_m = overview(points, UP, size=(200, 150)).project(points.astype(float))
    assert (depth_m > 0).all()
    assert ((pixels > -10) & (pixels < [210, 160])).all(axis=1).mean() == 1.0


def test_the_nearer_point_hides_the_farther_one() -> None:
    viewpoint = overview(floor_and_wall(), UP, size=(200, 150))
    R_camera_world, t = viewpoint.T_camera_world[:3, :3], viewpoint.T_camera_world[:3, 3]
    along = np.array([[0.1, 0.1, 4.0], [0.15, 0.15, 6.0]])
    points = ((along - t) @ R_camera_world).astype(np.float32)
    colours = np.array([[0, 0, 200], [200, 0, 0]], np.uint8)
    for order in ([0, 1], [1, 0]):
        image = draw_cloud(viewpoint, points[order], colours[order], point_m=0.05)
        (u, v), _ = (a[0] for a in viewpoint.project(points.astype(float)))
        assert image[int(v), int(u), 2] > 100
        assert tuple(image[0, 0]) == BACKGROUND


def test_instances_differ_in_colour_and_unassigned_points_are_grey() -> None:
    ids = np.arange(0, 50, dtype=np.int32)
    colours = instance_colours(ids, np.full((50, 3), 128, np.uint8))
    assert np.ptp(colours[0]) == 0
    assert len(np.unique(colours, axis=0)) == 50


def test_labels_change_only_the_picture_they_return() -> None:
    viewpoint = overview(floor_and_wall(), UP, size=(200, 150))
    image = np.full((150, 200, 3), 255, np.uint8)
    labelled = draw_labels(image, viewpoint, {"7 mug": np.array([1.0, 1.0, 0.0])})
    assert image.min() == 255
    assert labelled.min() < 60


@pytest.mark.parametrize("up", [(0, 0, 1), (0, -1, 0), (1, 0, 0)])
def test_any_axis_may_be_up(up: tuple[int, int, int]) -> None:
    viewpoint = overview(np.random.default_rng(0).random((500, 3), np.float32), np.array(up, float))
    down_in_camera = viewpoint.T_camera_world[:3, :3] @ np.array(up, float)
    assert down_in_camera[1] < -0.5
