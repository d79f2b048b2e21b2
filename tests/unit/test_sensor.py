"""Statistics of the two cameras."""

import numpy as np
import pytest

from sceneq_tools.room.camera.colour_sensor import ColourSensor, Motion
from sceneq_tools.room.camera.depth_sensor import DepthSensor
from sceneq_tools.room.camera.sensor import measure
from sceneq_tools.room.rendering import Rendering

from support.tiny_room import CAMERA

SHAPE = (120, 160)
STILL = DepthSensor(speckle_loss=0, disparity_step_px=0, edge_jitter_px=0)


def view(depth, incidence=1.0, rgb=120) -> Rendering:
    return Rendering(
        np.full((*SHAPE, 3), rgb, np.uint8),
        np.broadcast_to(np.asarray(depth, np.float32), SHAPE).copy(),
        np.ones(SHAPE, np.uint16),
        np.full(SHAPE, incidence, np.float32),
    )


def rng() -> np.random.Generator:
    return np.random.default_rng(5)


@pytest.mark.parametrize("depth_m", [1.0, 2.0, 4.0])
def test_noise_grows_with_the_square_of_depth(depth_m: float) -> None:
    measured = STILL.measure(view(depth_m), rng()) / 1000

    sigma = 0.0012 + 0.0019 * (depth_m - 0.4) ** 2
    assert measured.std() == pytest.approx(sigma, rel=0.15)
    assert measured.mean() == pytest.approx(depth_m, abs=sigma / 2)


def test_noise_is_smooth_as_matching_windows_make_it() -> None:
    error = STILL.measure(view(2.0), rng()) / 1000 - 2.0

    assert np.corrcoef(error[:, 1:].ravel(), error[:, :-1].ravel())[0, 1] > 0.7


def test_depth_comes_in_steps_of_disparity() -> None:
    measured = DepthSensor(speckle_loss=0, edge_jitter_px=0).measure(view(4.0), rng())

    steps = 43.2 / (np.unique(measured) / 1000) / 0.125
    assert len(steps) < 30
    np.testing.assert_allclose(steps, np.round(steps), atol=0.03)


@pytest.mark.parametrize(("depth_m", "incidence"), [(0.2, 1.0), (6.0, 1.0), (2.0, 0.05), (0, 1)])
def test_what_cannot_be_measured_is_a_hole(depth_m: float, incidence: float) -> None:
    assert not DepthSensor().measure(view(depth_m, incidence), rng()).any()


def test_the_projectors_shadow_lies_left_of_what_is_near() -> None:
    depth = np.full(SHAPE, 3.0)
    depth[:, 80:] = 1.0
    holes = STILL.measure(view(depth), rng()) == 0

    assert holes[:, 72:79].all()  # (43.2 / 1 - 43.2 / 3) px would be longer: it is cut off
    assert holes[:, 64:79].mean() > 0.95
    assert holes[:, :60].mean() < 0.01
    assert holes[:, 83:].mean() < 0.01


def test_edges_lose_about_the_share_they_are_said_to() -> None:
    depth = np.full(SHAPE, 3.0)
    depth[60:] = 1.0
    holes = STILL.measure(view(depth), rng()) == 0

    assert holes[59:61].mean() == pytest.approx(0.55, abs=0.15)
    assert not holes[:50].any()


def test_equal_generators_give_equal_pictures() -> None:
    one, other = measure(view(2.0), rng()), measure(view(2.0), rng())

    assert one[0].dtype == np.uint8
    assert one[1].dtype == np.uint16
    assert np.array_equal(one[0], other[0])
    assert np.array_equal(one[1], other[1])


def test_corners_are_darker_than_the_middle() -> None:
    picture = ColourSensor(read_noise=0, photons=1e9).measure(view(2.0, rgb=200), rng())

    light = (picture[..., 0] / 255.0) ** 2.2
    assert light[0, 0] / light[60, 80] == pytest.approx(0.85, abs=0.01)


def test_noise_is_that_of_counted_photons() -> None:
    sensor = ColourSensor(vignetting=0, blur_px=0)
    light = (sensor.measure(view(2.0, rgb=200), rng()) / 255.0) ** 2.2

    white = (200 / 255) ** 2.2
    assert light.std() == pytest.approx(np.sqrt(white * 8000 + 64) / 8000, rel=0.15)


def test_motion_blurs_along_the_way() -> None:
    T_next_camera = np.eye(4)
    T_next_camera[0, 3] = -0.2  # at 2 m and 100 px: 10 px to the left
    rendering = view(2.0)
    rendering.rgb[:] = 0
    rendering.rgb[:, 80:] = 255
    sensor = ColourSensor(read_noise=0, photons=1e9, blur_px=0, vignetting=0, shutter=1.0)
    blurred = sensor.measure(rendering, rng(), Motion(T_next_camera, CAMERA))

    mixed = (blurred[60, :, 0] > 5) & (blurred[60, :, 0] < 250)
    assert 7 <= mixed.sum() <= 12
    assert (blurred[:, :70] == 0).all()


@pytest.mark.parametrize("name", ["edge_loss", "speckle_loss"])
def test_a_share_lies_between_nothing_and_all(name: str) -> None:
    with pytest.raises(ValueError, match=name):
        DepthSensor(**{name: 1.5})
