"""What every segmenter promises."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_nodes._backends import build, kinds

from support.tiny_segmenters import network_spec

KINDS = sorted(kinds("segmenter"))
SHAPES = [(48, 64), (61, 97), (120, 160), (33, 400), (3, 5), (1, 1)]


def frame_of(shape, seed=5):
    height, width = shape
    rng = np.random.default_rng(seed)
    depth_m = np.full(shape, 2.0, np.float32)
    depth_m[height // 4 : height // 2, width // 4 : width // 2] = 1.2
    depth_m[rng.random(shape) < 0.05] = 0
    return Frame(
        seq=7,
        stamp_ns=70,
        rgb=rng.integers(0, 256, (*shape, 3), dtype=np.uint8),
        depth_m=depth_m,
        K=np.array([[width, 0, width / 2], [0, width, height / 2], [0, 0, 1]], float),
        T_world_camera=np.eye(4),
    )


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    return tmp_path_factory.mktemp("networks")


@pytest.fixture
def segmenter_for(tmp_path, networks):
    def made(kind, shape):
        spec = {"kind": kind, **network_spec(kind, networks)}
        if kind == "files":
            labels = np.zeros(shape, np.uint16)
            labels[: shape[0] // 2 + 1] = 9
            cv2.imwrite(str(tmp_path / "frame-000007.mask.png"), labels)
            spec["path"] = str(tmp_path)
        return build("segmenter", spec)

    return made


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("shape", SHAPES)
def test_labels_are_uint16_of_the_frames_size(kind, shape, segmenter_for):
    labels = segmenter_for(kind, shape).segment(frame_of(shape))
    assert labels.dtype == np.uint16
    assert labels.shape == shape
    assert labels.flags.c_contiguous


@pytest.mark.parametrize("kind", KINDS)
def test_same_frame_gives_same_labels_and_is_left_alone(kind, segmenter_for):
    frame = frame_of((120, 160))
    before = frame.rgb.copy(), frame.depth_m.copy()
    segmenter = segmenter_for(kind, (120, 160))
    first = segmenter.segment(frame)
    segmenter.segment(replace(frame, rgb=255 - frame.rgb))
    assert np.array_equal(segmenter.segment(frame), first)
    assert np.array_equal(segmenter_for(kind, (120, 160)).segment(frame), first)
    assert np.array_equal(frame.rgb, before[0])
    assert np.array_equal(frame.depth_m, before[1])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("depth", [0.0, 1.5])
@pytest.mark.parametrize("constant", [True, False])
def test_empty_or_flat_input_is_no_error(kind, depth, constant, segmenter_for):
    frame = frame_of((48, 64))
    rgb = np.full_like(frame.rgb, 90) if constant else frame.rgb
    frame = replace(frame, rgb=rgb, depth_m=np.full((48, 64), depth, np.float32))
    assert segmenter_for(kind, (48, 64)).segment(frame).shape == (48, 64)


@pytest.mark.parametrize("kind", KINDS)
def test_read_only_images_are_fine(kind, segmenter_for):
    frame = frame_of((48, 64))
    for image in (frame.rgb, frame.depth_m):
        image.flags.writeable = False
    assert segmenter_for(kind, (48, 64)).segment(frame).shape == (48, 64)
