"""The segmentation node on the fake bus."""

import re
from dataclasses import replace

import cv2
import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_nodes._images import frame_message
from sceneq_nodes._params import ParamError
from sceneq_nodes.segmentation import Segmentation, SegmentationParams
from sceneq_schemas.topics import FRAME, MASK

from support.fake_bus import CONTEXT, FakeBus

SHAPE = (48, 64)


def message(seq=4):
    rng = np.random.default_rng(seq)
    depth_m = np.full(SHAPE, 2.0, np.float32)
    depth_m[10:30, 20:40] = 1.0
    rgb = rng.integers(0, 256, (*SHAPE, 3), dtype=np.uint8)
    K = np.array([[60.0, 0, 31.5], [0, 60.0, 23.5], [0, 0, 1]])
    return frame_message(Frame(seq, seq * 10, rgb, depth_m, K, np.eye(4)), "raw", "zstd")


def opened(bus, **params):
    node = Segmentation(SegmentationParams(**params), bus.context)
    node.open(bus)
    return node


def test_masks_carry_the_frames_seq_and_stamp():
    bus = FakeBus()
    bus.deliver(opened(bus), FRAME, message(4))
    topic, ids, masks = bus.published[0]
    assert (topic, ids) == (MASK, {"scene": CONTEXT.scene})
    assert (masks.seq, masks.stamp_ns) == (4, 40)
    assert masks.label_image.shape == SHAPE
    inside, outside = masks.label_image[20, 30], masks.label_image[40, 5]
    assert inside != outside
    assert inside > 0


def test_it_listens_to_its_own_sensor_with_the_given_inbox():
    bus = FakeBus()
    opened(bus, inbox=3)
    key = FRAME.key(robot=CONTEXT.robot, sensor=CONTEXT.sensor)
    assert bus.subscriptions == {key: 3}


def test_a_frame_that_comes_again_is_answered_again():
    bus = FakeBus()
    node = opened(bus)
    for _ in range(2):
        bus.deliver(node, FRAME, message(4))
    first, second = bus.sent(MASK)
    assert first.seq == second.seq
    assert np.array_equal(first.label_image, second.label_image)


def test_a_frame_that_does_not_decode_is_counted_and_skipped(caplog):
    bus = FakeBus()
    node = opened(bus)
    good = message(5)
    bus.deliver(node, FRAME, replace(good, rgb=replace(good.rgb, data=b"short")))
    bus.deliver(node, FRAME, message(6))
    assert [masks.seq for masks in bus.sent(MASK)] == [6]
    assert bus.counters == {"frames_undecodable": 1}
    assert "frame 5" in caplog.text


def test_masks_from_files(tmp_path):
    labels = np.arange(SHAPE[0] * SHAPE[1], dtype=np.uint16).reshape(SHAPE)
    cv2.imwrite(str(tmp_path / "frame-000004.mask.png"), labels)
    bus = FakeBus()
    node = opened(bus, segmenter={"kind": "files", "path": str(tmp_path)})
    bus.deliver(node, FRAME, message(4))
    assert np.array_equal(bus.sent(MASK)[0].label_image, labels)


@pytest.mark.parametrize(
    ("image", "reason"),
    [
        (None, "No such file"),
        (np.zeros((4, 4), np.uint16), "expected \\(H, W\\) = \\(48, 64\\), got \\(4, 4\\)"),
        (np.zeros((*SHAPE, 3), np.uint8), "expected grey"),
    ],
)
def test_missing_or_wrong_masks_are_counted_and_published_empty(tmp_path, caplog, image, reason):
    if image is not None:
        cv2.imwrite(str(tmp_path / "frame-000004.mask.png"), image)
    bus = FakeBus()
    node = opened(bus, segmenter={"kind": "files", "path": str(tmp_path)})
    bus.deliver(node, FRAME, message(4))
    assert not bus.sent(MASK)[0].label_image.any()
    assert bus.counters == {"masks_missing": 1}
    assert "frame-000004.mask.png" in caplog.text
    assert re.search(reason, caplog.text)


def test_a_cut_off_file_is_named(tmp_path, caplog):
    path = tmp_path / "frame-000004.mask.png"
    cv2.imwrite(str(path), np.ones(SHAPE, np.uint16))
    path.write_bytes(path.read_bytes()[:-20])
    bus = FakeBus()
    node = opened(bus, segmenter={"kind": "files", "path": str(tmp_path)})
    bus.deliver(node, FRAME, message(4))
    assert bus.counters == {"masks_missing": 1}


def test_a_missing_folder_or_unknown_kind_stops_the_node_at_open(tmp_path):
    with pytest.raises(ValueError, match="no folder"):
        opened(FakeBus(), segmenter={"kind": "files", "path": str(tmp_path / "none")})
    with pytest.raises(ParamError, match=r"segmenter\.kind: unknown"):
        opened(FakeBus(), segmenter={"kind": "rgbdd"})


def test_idle_and_close_do_nothing():
    bus = FakeBus()
    node = opened(bus)
    node.step(None)
    node.close()
    assert bus.published == []


def test_an_inbox_of_none_is_refused():
    with pytest.raises(ValueError, match="inbox"):
        SegmentationParams(inbox=0)
