"""Segmenters as ONNX whose output is known: the masks are asserted pixel by pixel."""

import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_core.segmentation.prototype_masks import DetectionParams
from sceneq_nodes._model_error import ModelError
from sceneq_nodes._onnx_segmenter import OnnxSegmenter, OnnxSegmenterParams

from support.tiny_segmenters import write_detector, write_label_map


def frame(height, width):
    return Frame(
        seq=0,
        stamp_ns=0,
        rgb=np.zeros((height, width, 3), np.uint8),
        depth_m=np.ones((height, width), np.float32),
        K=np.array([[width, 0, width / 2], [0, width, height / 2], [0, 0, 1]], float),
        T_world_camera=np.eye(4),
    )


def segment(path, size=(64, 64), **changes):
    return OnnxSegmenter(OnnxSegmenterParams(model=str(path), **changes)).segment(frame(*size))


@pytest.fixture
def detector(tmp_path):
    return write_detector(tmp_path / "detector.onnx")


def test_detections_become_masks_within_their_boxes(detector):
    wanted = np.zeros((64, 64), np.uint16)
    wanted[:, :32] = 1  # of all the picture, where its prototype is positive
    wanted[16:32, 40:56] = 2
    assert np.array_equal(segment(detector), wanted)


def test_the_letterbox_is_taken_off(detector):
    """A picture of 128 x 64 lies in the middle of the input, 32 pixels high, from row 16 on."""
    wanted = np.zeros((64, 128), np.uint16)
    wanted[:, :64] = 1
    wanted[0:32, 80:112] = 2
    assert np.array_equal(segment(detector, (64, 128)), wanted)


def test_a_squashed_picture_is_stretched_back(detector):
    wanted = np.zeros((64, 128), np.uint16)
    wanted[:, :64] = 1
    wanted[16:32, 80:112] = 2
    assert np.array_equal(segment(detector, (64, 128), fit="squash"), wanted)


def test_the_weak_and_the_double_come_with_other_thresholds(detector):
    params = DetectionParams(score_min=0.05, nms_iou=0.95, least_px=4)
    labels = segment(detector, detections=params)
    assert labels.max() == 4
    assert (labels[6:14, 6:14] == 4).all()
    assert (labels[17:31, 40:56] == 3).all()
    assert segment(detector, detections=DetectionParams(most=1)).max() == 1


def test_nothing_sure_is_an_empty_image(detector):
    assert not segment(detector, detections=DetectionParams(score_min=0.95)).any()


@pytest.mark.parametrize("shape", [(32, 32), (1, 32, 32), (1, 1, 32, 32)])
@pytest.mark.parametrize("dtype", [np.int64, np.uint8])
def test_a_label_image_is_taken_as_it_is(shape, dtype, tmp_path):
    given = np.zeros((32, 32), dtype)
    given[:, 16:] = 7
    given[8:16, 4:12] = 3
    path = write_label_map(tmp_path / "labels.onnx", given.reshape(shape))
    wanted = np.zeros((64, 64), np.uint16)
    wanted[:, 32:] = 2
    wanted[16:32, 8:24] = 1
    assert np.array_equal(segment(path), wanted)


def test_labels_out_of_range_are_refused(tmp_path):
    path = write_label_map(tmp_path / "labels.onnx", np.full((1, 4, 4), -1, np.int64))
    with pytest.raises(ValueError, match=r"labels\.onnx: labels from -1 to -1 are not in 0"):
        segment(path)


def test_an_output_of_no_known_kind_is_told_with_its_shape(tmp_path):
    path = write_label_map(tmp_path / "scores.onnx", np.zeros((1, 5, 8, 8), np.float32))
    with pytest.raises(ModelError, match=r"expected detections .* it gives float32 \(1, 5, 8, 8\)"):
        segment(path)


def test_files_that_are_missing_or_no_networks_are_named(tmp_path):
    path = tmp_path / "network.onnx"
    with pytest.raises(ValueError, match=r"network\.onnx: no such file; expected a segmentation"):
        segment(path)
    path.write_bytes(b"no network")
    with pytest.raises(ModelError, match=r"network\.onnx: no usable ONNX model"):
        segment(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [("device", "tpu"), ("threads", 0), ("fill", 300), ("std", (0.0, 1.0, 1.0))],
)
def test_bad_parameters_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}:"):
        OnnxSegmenterParams(**{"model": "m", name: value})


@pytest.mark.parametrize(("name", "value"), [("score_min", 2), ("nms_iou", -1), ("most", 0)])
def test_bad_thresholds_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}:"):
        DetectionParams(**{name: value})
