"""The rgbd segmenter on a rendered table: what it separates, and what it keeps whole."""

import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_core.segmentation.rgbd import RgbdParams, RgbdSegmenter

H, W, F = 240, 320, 262.0
K = np.array([[F, 0, (W - 1) / 2], [0, F, (H - 1) / 2], [0, 0, 1]])
FLOOR_Y, WALL_Z = 0.7, 2.6
CUP = (0.25, 1.5, 0.06, 0.16)
WOOD, RED, WHITE, BLUE = (150, 110, 70), (180, 30, 30), (205, 205, 205), (30, 60, 170)


def room(seed=0):
    """Return a frame: floor, wall with a poster, and on the floor a cup and a sheet of paper."""
    v, u = np.mgrid[:H, :W]
    ray = np.stack([(u - K[0, 2]) / F, (v - K[1, 2]) / F, np.ones((H, W))], axis=2)
    floor = np.where(ray[..., 1] > 1e-6, FLOOR_Y / np.maximum(ray[..., 1], 1e-6), np.inf)
    depth = np.minimum(floor, WALL_Z)
    truth = np.where(floor < WALL_Z, 1, 2)
    points = ray * depth[..., None]
    truth[_within(points, 0, -0.9, -0.4) & _within(points, 1, -0.7, -0.1) & (truth == 2)] = 3
    truth[_within(points, 0, -0.5, -0.2) & _within(points, 2, 1.5, 1.8) & (truth == 1)] = 4
    cup = _cylinder(ray, *CUP)
    truth[cup < depth] = 5
    depth = np.minimum(depth, cup)
    colours = np.array([(0, 0, 0), WOOD, (120, 125, 120), BLUE, WHITE, RED])
    rng = np.random.default_rng(seed)
    rgb = np.clip(colours[truth] + rng.normal(0, 2, (H, W, 3)), 0, 255).astype(np.uint8)
    noisy = depth + rng.normal(0, 1, (H, W)) * 0.0007 * depth**2
    return Frame(1, 1, rgb, noisy.astype(np.float32), K, np.eye(4)), truth


def _within(points, axis, low, high):
    return (points[..., axis] > low) & (points[..., axis] < high)


def _cylinder(ray, x, z, radius, height):
    """Return the depth of an upright cylinder on the floor, inf where it is not hit."""
    a = ray[..., 0] ** 2 + 1
    b = ray[..., 0] * x + z
    root = b**2 - a * (x**2 + z**2 - radius**2)
    depth = np.where(root > 0, (b - np.sqrt(np.maximum(root, 0))) / a, np.inf)
    y = ray[..., 1] * np.where(np.isfinite(depth), depth, 0)
    return np.where((y < FLOOR_Y) & (y > FLOOR_Y - height), depth, np.inf)


def best_iou(labels, mask):
    ids = np.unique(labels[mask])
    pairs = [(labels == i) for i in ids if i > 0]
    return max(((p & mask).sum() / (p | mask).sum() for p in pairs), default=0.0)


@pytest.fixture(scope="module")
def segmented():
    frame, truth = room()
    return RgbdSegmenter(RgbdParams()).segment(frame), truth


@pytest.mark.parametrize(("thing", "least"), [(1, 0.9), (2, 0.9), (3, 0.85), (4, 0.75), (5, 0.75)])
def test_floor_wall_poster_paper_and_cup_are_segments(segmented, thing, least):
    labels, truth = segmented
    assert best_iou(labels, truth == thing) > least


def test_every_thing_has_its_own_segment(segmented):
    labels, truth = segmented
    main = [np.bincount(labels[truth == thing]).argmax() for thing in range(1, 6)]
    assert len(set(main)) == 5


def test_ids_are_consecutive(segmented):
    labels, _ = segmented
    present = np.unique(labels[labels > 0])
    assert present.tolist() == list(range(1, len(present) + 1))


def test_without_depth_colour_alone_finds_the_poster():
    frame, truth = room()
    blind = Frame(1, 1, frame.rgb, np.zeros_like(frame.depth_m), K, np.eye(4))
    labels = RgbdSegmenter(RgbdParams()).segment(blind)
    assert best_iou(labels, truth == 3) > 0.85


def test_without_colour_depth_alone_finds_the_cup_and_not_the_poster():
    frame, truth = room()
    grey = Frame(1, 1, np.full_like(frame.rgb, 128), frame.depth_m, K, np.eye(4))
    labels = RgbdSegmenter(RgbdParams()).segment(grey)
    assert best_iou(labels, truth == 5) > 0.7
    assert best_iou(labels, truth == 3) < 0.5


@pytest.mark.parametrize("factor", [2, 3])
def test_larger_images_give_the_same_things(factor):
    frame, truth = room()
    up = [a.repeat(factor, 0).repeat(factor, 1) for a in (frame.rgb, frame.depth_m, truth)]
    large = Frame(1, 1, up[0], up[1], np.diag([factor, factor, 1.0]) @ K, np.eye(4))
    labels = RgbdSegmenter(RgbdParams()).segment(large)
    assert labels.shape == up[2].shape
    assert best_iou(labels, up[2] == 5) > 0.75


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("width_px", 0),
        ("depth_noise", -1.0),
        ("min_height_m", 0.0),
        ("colour_scale", 0.0),
        ("contrast", -3.0),
        ("min_fold_deg", 180.0),
        ("min_share", 0.0),
        ("min_plane_share", 1.0),
    ],
)
def test_bad_parameters_are_named(name, value):
    with pytest.raises(ValueError, match=name):
        RgbdParams(**{name: value})
