"""Corners where surfaces meet, and the light that is mixed in there."""

import numpy as np

from sceneq_tools.room.light.antialias import CORNER_SHARE, around_corners, blended, edge_corners


def corners_of(surface: np.ndarray, depth_m: float | np.ndarray = 2.0) -> np.ndarray:
    grey = np.full((*surface.shape, 3), 0.2, np.float32)
    depth = np.broadcast_to(np.float32(depth_m), surface.shape)
    return edge_corners(grey, surface.astype(np.int32), depth, np.full_like(depth, 0.01))


def test_one_corner_for_each_row_of_an_upright_edge() -> None:
    surface = np.zeros((5, 6))
    surface[:, 3:] = 1

    assert np.argwhere(corners_of(surface)).tolist() == [[y, 2] for y in range(4)]


def test_a_pixel_of_its_own_has_four_corners() -> None:
    surface = np.zeros((5, 6))
    surface[2, 3] = 1

    assert np.argwhere(corners_of(surface)).tolist() == [[1, 2], [1, 3], [2, 2], [2, 3]]


def test_a_step_in_depth_is_an_edge_and_a_slope_is_none() -> None:
    flat = np.zeros((5, 6))
    slope = np.tile(2 + 0.01 * np.arange(6), (5, 1))
    step = slope + (np.arange(6) > 2)

    assert not corners_of(flat, slope).any()
    assert corners_of(flat, step).sum() == 4


def test_rays_go_through_corners_in_the_order_of_the_picture() -> None:
    corners = np.zeros((3, 4), bool)
    corners[0, 3] = corners[2, 1] = True

    assert around_corners(corners, 1).tolist() == [[[3.5, 0.5], [1.5, 2.5]]]
    two = around_corners(corners, 2)
    assert two.shape == (2, 2, 2)
    np.testing.assert_allclose(two.mean(axis=0), [[3.5, 0.5], [1.5, 2.5]])


def test_a_corner_gives_an_eighth_to_each_of_its_pixels() -> None:
    corners = np.zeros((2, 3), bool)
    corners[0, 1] = True
    smooth = blended(np.zeros((3, 4, 3), np.float32), corners, np.ones((1, 3), np.float32))

    expected = np.zeros((3, 4))
    expected[:2, 1:3] = CORNER_SHARE
    np.testing.assert_array_equal(smooth, np.repeat(expected[..., None], 3, axis=2))


def test_a_picture_without_edges_stays_as_it_is() -> None:
    picture = np.random.default_rng(1).random((3, 4, 3), np.float32)
    nothing = np.zeros((0, 3), np.float32)

    assert np.array_equal(blended(picture, np.zeros((2, 3), bool), nothing), picture)
