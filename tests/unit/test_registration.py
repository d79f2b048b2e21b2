"""Depth warped into the colour camera."""

import numpy as np
import pytest

from sceneq_core.ingest.registration import DepthRegistration, RegistrationParams
from sceneq_core.ingest.source import Camera

DEPTH = Camera(np.array([[100.0, 0, 40], [0, 100, 30], [0, 0, 1]]), (80, 60))


def shifted(x_m: float = 0.0, z_m: float = 0.0) -> np.ndarray:
    T_color_depth = np.eye(4)
    T_color_depth[[0, 2], 3] = x_m, z_m
    return T_color_depth


def flat(mm: int) -> np.ndarray:
    return np.full((60, 80), mm, np.uint16)


def test_one_camera_is_left_alone() -> None:
    registration = DepthRegistration(DEPTH, DEPTH, np.eye(4))
    depth = flat(1234)
    assert registration.is_identity
    assert registration.register(depth) is depth


def test_a_shifted_camera_sees_near_things_further_aside() -> None:
    registration = DepthRegistration(DEPTH, DEPTH, shifted(x_m=-0.1))
    depth = flat(2000)
    depth[20:40, 30:50] = 1000
    seen = registration.register(depth)
    assert (seen[20:40, 20:40] == 1000).all()  # 100 px * 0.1 m / 1 m to the left
    assert (seen[20:40, 0:20] == 2000).all()  # the wall, by half as much
    assert (seen[20:40, 40:45] == 0).all()  # what the depth camera saw no part of
    assert (seen[:20, :75] == 2000).all()
    assert (seen[:, 75:] == 0).all()


def test_the_nearer_surface_wins_whatever_the_order() -> None:
    for x_m in (-0.1, 0.1):
        registration = DepthRegistration(DEPTH, DEPTH, shifted(x_m))
        depth = flat(3000)
        depth[:, 38:42] = 500
        seen = registration.register(depth)
        # 20 px aside, and 3.33 px of wall behind it: the pole is whole
        start = 38 + round(x_m * 200)
        assert (seen[:, start : start + 4] == 500).all()


def test_depth_is_measured_from_the_colour_camera() -> None:
    seen = DepthRegistration(DEPTH, DEPTH, shifted(z_m=0.25)).register(flat(1000))
    assert set(np.unique(seen)) == {0, 1250}
    behind = DepthRegistration(DEPTH, DEPTH, shifted(z_m=-2.0)).register(flat(1000))
    assert not behind.any()


@pytest.mark.parametrize("scale", [1.0, 1.3, 2.0, 3.0])
def test_a_finer_colour_camera_gets_a_closed_surface(scale: float) -> None:
    K = DEPTH.K * [[scale], [scale], [1]]
    color = Camera(K, (round(80 * scale), round(60 * scale)))
    seen = DepthRegistration(DEPTH, color, np.eye(4)).register(flat(1500))
    margin = int(scale)
    assert seen.shape == color.size[::-1]
    assert (seen[margin:-margin, margin:-margin] == 1500).all()


def test_a_slanted_surface_has_no_cracks() -> None:
    columns = 1000 / (1 - 0.9 * (np.arange(80) - 40) / 100)  # a plane, 42 degrees off
    depth = np.tile(columns, (60, 1)).astype(np.uint16)
    seen = DepthRegistration(DEPTH, DEPTH, shifted(x_m=-0.05)).register(depth)
    inner = seen[5:-5, 10:70]
    assert inner.all()
    assert np.abs(np.diff(inner.astype(int), axis=1)).max() < 60


def test_nothing_is_smeared_over_an_edge() -> None:
    depth = flat(0)
    depth[:, :40], depth[:, 41:] = 1000, 1500
    camera = Camera(DEPTH.K + np.array([[0, 0, 1], [0, 0, 0], [0, 0, 0]]), DEPTH.size)
    seen = DepthRegistration(DEPTH, camera, np.eye(4)).register(depth)
    assert (seen[:, 41] == 0).all()
    depth[:, 41:] = 1010
    seen = DepthRegistration(DEPTH, camera, np.eye(4)).register(depth)
    assert (seen[1:-1, 41] == 1005).all()


def test_an_image_without_depth_stays_empty() -> None:
    seen = DepthRegistration(DEPTH, DEPTH, shifted(x_m=0.02)).register(flat(0))
    assert not seen.any()
    assert seen.dtype == np.uint16


def test_a_slope_of_90_degrees_is_refused() -> None:
    with pytest.raises(ValueError, match="max_slope_deg"):
        RegistrationParams(90.0)
