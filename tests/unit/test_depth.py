"""Rays of pixels, and depth with the noise averaged out."""

import numpy as np
import pytest

from sceneq_core.depth import inverse_depth, pixel_rays, smoothed_depth

K = np.array([[100.0, 0, 20], [0, 50.0, 10], [0, 0, 1]])


def smoothed(depth_m, same_surface=0.05):
    _, mean = inverse_depth(depth_m, depth_m > 0, 2)
    return smoothed_depth(depth_m, mean, same_surface)


def test_rays_are_zero_at_the_principal_point_and_keep_the_stride():
    x, y = pixel_rays(K, (30, 41), stride=2)
    assert (x.shape, y.shape) == ((21,), (15,))
    assert (x[10], y[5]) == (0, 0)
    assert (x[-1], y[-1]) == (pytest.approx(0.2), pytest.approx(0.36))


def test_a_tilted_plane_stays_that_plane():
    inverse = 0.5 + 0.001 * np.arange(60) + np.zeros((40, 1))
    depth_m = (1 / inverse).astype(np.float32)
    inside = np.s_[2:-2, 2:-2]
    assert smoothed(depth_m)[inside] == pytest.approx(depth_m[inside], rel=1e-5)


def test_noise_is_averaged_but_edges_stay():
    rng = np.random.default_rng(0)
    depth_m = np.where(np.arange(60) < 30, 1.0, 2.0) * (1 + rng.normal(0, 0.003, (40, 60)))
    result = smoothed(depth_m.astype(np.float32))
    assert np.std(result[:, :27]) < 0.3 * np.std(depth_m[:, :27])
    assert abs(result[:, 29] - 1.0).max() < 0.02
    assert abs(result[:, 30] - 2.0).max() < 0.04


def test_what_was_not_measured_stays_unmeasured_and_counts_for_nothing():
    depth_m = np.full((20, 20), 2.0, np.float32)
    depth_m[5:15, 5:15] = 0
    inverse, mean = inverse_depth(depth_m, depth_m > 0, 2)
    assert (inverse[5:15, 5:15] == 0).all()
    assert mean[5, 5] == pytest.approx(0.5)
    assert mean[10, 10] == 0
    assert (smoothed(depth_m) == np.where(depth_m > 0, 2.0, 0.0)).all()
