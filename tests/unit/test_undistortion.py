"""A lens undone: where a pinhole would have put the pixels."""

import numpy as np
import pytest

from sceneq_core.ingest.undistortion import Lens, Undistortion
from sceneq_nodes.ros.camera_info import info_topic, is_rectified, lens
from sceneq_nodes.ros.typestore import WireError

from support.ros_robot import Robot

K = np.array([[100.0, 0, 79.5], [0, 100.0, 59.5], [0, 0, 1]])
SIZE = (160, 120)
MODELS = {
    "plumb_bob": (-0.25, 0.08, 0.001, -0.002, 0.01),
    "rational_polynomial": (0.3, -0.1, 0.001, 0.0005, 0.02, 0.5, -0.05, 0.01),
    "equidistant": (-0.02, 0.004, -0.001, 0.0002),
}
ROBOT = Robot()


def distorted(model, d, x, y):
    """Where the lens puts the ray (x, y, 1), by the formulas of the models."""
    r2 = x * x + y * y
    if model == "equidistant":
        r = np.sqrt(r2)
        theta = np.arctan(r)
        t2 = theta * theta
        grown = theta * (1 + t2 * (d[0] + t2 * (d[1] + t2 * (d[2] + t2 * d[3])))) / r
        return x * grown, y * grown
    k1, k2, p1, p2, k3 = d[:5]
    k4, k5, k6 = d[5:8] if len(d) > 5 else (0, 0, 0)
    grown = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    xd = x * grown + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    return xd, y * grown + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y


@pytest.mark.parametrize("model", MODELS)
def test_every_pixel_comes_from_where_the_formula_says(model):
    d = MODELS[model]
    v, u = np.mgrid[:120, :160].astype(float)
    xd, yd = distorted(model, d, (u - 79.5) / 100, (v - 59.5) / 100)
    ud, vd = 100 * xd + 79.5, 100 * yd + 59.5
    # Depth that says in which column and row it was measured.
    taken = (np.arange(120)[:, None] * 200 + np.arange(160) + 1).astype(np.uint16)
    found = Undistortion(Lens(K, SIZE, model, np.array(d))).depth_mm(taken)
    inside = (ud > 1) & (ud < 158) & (vd > 1) & (vd < 118)
    assert inside.mean() > 0.6
    row, column = divmod(found.astype(int) - 1, 200)
    assert np.abs(column - ud)[inside].max() <= 0.55
    assert np.abs(row - vd)[inside].max() <= 0.55
    outside = (ud < -1) | (ud > 160) | (vd < -1) | (vd > 120)
    assert not found[outside].any()


def test_depth_is_never_mixed_and_colour_is():
    halves = np.where(np.arange(160) < 80, 1000, 3000)
    depth_mm = np.tile(halves, (120, 1)).astype(np.uint16)
    undo = Undistortion(Lens(K, SIZE, "plumb_bob", np.array(MODELS["plumb_bob"])))
    assert set(np.unique(undo.depth_mm(depth_mm))) <= {0, 1000, 3000}
    rgb = np.repeat((depth_mm // 20).astype(np.uint8)[..., None], 3, axis=2)
    assert len(np.unique(undo.rgb(rgb))) > 3


def test_without_distortion_nothing_is_touched():
    rgb = np.zeros((120, 160, 3), np.uint8)
    assert Undistortion(Lens(K, SIZE)).rgb(rgb) is rgb
    with pytest.raises(ValueError, match="image is 120x160, camera_info says 160x120"):
        Undistortion(Lens(K, SIZE)).rgb(rgb.transpose(1, 0, 2))


@pytest.mark.parametrize(
    ("model", "d", "said"),
    [
        ("plumb_bob", [1, 0, 0], "3 coefficients, not 4 or 5"),
        ("equidistant", [1, 0, 0, 0, 0], "5 coefficients, not 4"),
        ("omnidirectional", [1, 0, 0, 0], "unknown distortion model 'omnidirectional'"),
        ("plumb_bob", [np.nan] * 5, "not finite"),
    ],
)
def test_a_lens_nobody_knows_is_refused(model, d, said):
    with pytest.raises(ValueError, match=said):
        Lens(K, SIZE, model, np.array(d, float))


def test_a_camera_info_becomes_a_lens():
    found = lens(ROBOT.info(K, SIZE, "plumb_bob", MODELS["plumb_bob"]), is_rectified=False)
    assert (found.model, found.size) == ("plumb_bob", SIZE)
    assert found.coefficients.tolist() == list(MODELS["plumb_bob"])
    assert found.K.tolist() == K.tolist()


def test_rectified_images_are_a_pinhole_with_p():
    p = np.array([[90.0, 0, 80, 0], [0, 91.0, 60, 0], [0, 0, 1, 0]])
    info = ROBOT.info(K, SIZE, "plumb_bob", MODELS["plumb_bob"], p=p.reshape(12))
    found = lens(info, is_rectified=True)
    assert found.is_pinhole
    assert found.K.tolist() == p[:, :3].tolist()
    assert is_rectified("/camera/color/image_rect_color/compressed")
    assert not is_rectified("/camera/correct/image_raw")


def test_binning_and_a_region_of_interest():
    roi = ROBOT.types["sensor_msgs/msg/RegionOfInterest"](20, 40, 80, 100, False)
    info = ROBOT.info(K, SIZE, binning_x=2, binning_y=2, roi=roi)
    found = lens(info, is_rectified=False)
    assert found.size == (50, 40)
    assert found.K.tolist() == [[50, 0, (79.5 - 20) / 2], [0, 50, (59.5 - 40) / 2], [0, 0, 1]]


def test_a_camera_info_without_calibration_is_refused():
    with pytest.raises(WireError, match="not calibrated"):
        lens(ROBOT.info(np.zeros((3, 3)), SIZE), is_rectified=False)
    with pytest.raises(WireError, match="size: 0x0"):
        lens(ROBOT.info(K, (0, 0)), is_rectified=False)
    with pytest.raises(WireError, match="unknown distortion model 'mystery'"):
        lens(ROBOT.info(K, SIZE, "mystery", (0.1,) * 5), is_rectified=False)


def test_the_camera_info_lies_beside_the_image():
    for topic in ("image_raw", "image_raw/compressed", "image_raw/compressedDepth"):
        assert info_topic(f"/camera/color/{topic}") == "/camera/color/camera_info"
