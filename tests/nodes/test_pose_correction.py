"""Corrections of poses, from ingest or anybody else, on their way into map and views."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.ingest.ingestor import Ingested, Ingestor
from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._corrections import MAX_WAITING
from sceneq_nodes._images import frame_message
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.ingest import Ingest, IngestParams
from sceneq_nodes.mapping import Mapping, MappingParams
from sceneq_nodes.views import Views, ViewsParams
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import FRAME, MAP_DELTA, MAP_SNAPSHOT, MASK, POSE_CORRECTION, VIEW_DELTA
from sceneq_schemas.view import ViewDelta

from support.fake_bus import CONTEXT, FakeBus, FakeHub
from support.room import Room
from support.seven_scenes import write_folder
from support.surfaces import SMALL, room_frames

VIEWS = room_frames(4, Room(size=(96, 72), focal_px=78.0))
SHIFT = np.eye(4)
SHIFT[0, 3] = 0.1


def frame_of(seq, T_error=SHIFT):
    frame = VIEWS[seq][0]
    return frame_message(
        replace(frame, T_world_camera=T_error @ frame.T_world_camera), "raw", "raw"
    )


def masks_of(seq):
    frame, instance = VIEWS[seq]
    return Masks(frame.seq, frame.stamp_ns, instance)


def right(*seqs, frame_seq=0, seq=1):
    poses = np.array([VIEWS[i][0].T_world_camera for i in seqs]).reshape(-1, 4, 4)
    return PoseCorrection(1, seq, True, frame_seq, 0, np.array(seqs, np.int64), poses)


def opened():
    bus = FakeBus()
    node = Mapping(MappingParams(mapper=SMALL), bus.context)
    node.open(bus)
    return node, bus


def show(node, bus, *seqs, T_error=SHIFT):
    for seq in seqs:
        bus.deliver(node, FRAME, frame_of(seq, T_error))
        bus.deliver(node, MASK, masks_of(seq))


def snapshot(bus):
    replica = MapReplica()
    reply = bus.query(MAP_SNAPSHOT)
    replica.apply(map_delta_from_message(from_bytes(MAP_SNAPSHOT, reply.payload)))
    return replica


def test_the_map_moves_when_poses_are_corrected():
    node, bus = opened()
    show(node, bus, 0, 1, 2)
    wrong = snapshot(bus)
    bus.deliver(node, POSE_CORRECTION, right(0, 1, 2))
    delta = bus.sent(MAP_DELTA)[-1]
    assert (delta.full, delta.seq, delta.frame_seq) == (True, 4, 2)
    assert len(delta.moved_from_id) == len(delta.moved_to_id) == wrong.alive.sum()
    assert bus.counters["corrections_applied"] == 1
    moved = snapshot(bus)
    assert set(moved.instances) == set(wrong.instances) != set()
    for instance_id, instance in moved.instances.items():
        step = instance.centre_world - wrong.instances[instance_id].centre_world
        np.testing.assert_allclose(step, (-0.1, 0, 0), atol=0.005)


def test_a_correction_waits_for_the_frame_from_which_on_it_holds():
    node, bus = opened()
    show(node, bus, 0, 1)
    bus.deliver(node, POSE_CORRECTION, right(0, 1, 2, frame_seq=3))
    assert [d.full for d in bus.sent(MAP_DELTA)] == [False, False]
    show(node, bus, 2)  # was sent before the correction, and still belongs before it
    assert [d.full for d in bus.sent(MAP_DELTA)] == [False] * 3
    show(node, bus, 3, T_error=np.eye(4))
    assert [d.full for d in bus.sent(MAP_DELTA)] == [False] * 3 + [True, False]


def test_a_frame_that_comes_after_its_own_correction_has_the_new_pose():
    node, bus = opened()
    show(node, bus, 0)
    bus.deliver(node, POSE_CORRECTION, right(0, 1))
    show(node, bus, 1)
    late = snapshot(bus)
    other, other_bus = opened()
    show(other, other_bus, 0)
    other_bus.deliver(other, POSE_CORRECTION, right(0))
    show(other, other_bus, 1, T_error=np.eye(4))
    for one, two in zip(late.cloud(), snapshot(other_bus).cloud(), strict=True):
        np.testing.assert_array_equal(one, two)


def test_a_repeated_correction_changes_nothing():
    node, bus = opened()
    show(node, bus, 0, 1)
    bus.deliver(node, POSE_CORRECTION, right(0, 1))
    before, told = snapshot(bus).cloud(), len(bus.sent(MAP_DELTA))
    bus.deliver(node, POSE_CORRECTION, right(0, 1, seq=2))
    assert len(bus.sent(MAP_DELTA)) == told
    for one, two in zip(before, snapshot(bus).cloud(), strict=True):
        np.testing.assert_array_equal(one, two)


def test_nonsense_is_counted_and_logged(caplog: pytest.LogCaptureFixture):
    node, bus = opened()
    show(node, bus, 0)
    bus.deliver(node, POSE_CORRECTION, replace(right(0), T_world_camera=np.full((1, 4, 4), 2.0)))
    assert bus.counters["corrections_refused"] == 1
    assert "correction 1:1 refused: T_world_camera: not rigid" in caplog.text
    for seq in range(MAX_WAITING + 1):
        bus.deliver(node, POSE_CORRECTION, right(0, frame_seq=99 + seq, seq=seq))
    assert bus.counters["corrections_refused"] == 2
    assert len(bus.sent(MAP_DELTA)) == 1


def test_views_keep_showing_what_has_moved():
    hub = FakeHub()
    mapping = hub.add(Mapping, MappingParams(mapper=SMALL), replace(CONTEXT, node="mapping"))
    views = hub.add(Views, ViewsParams(), replace(CONTEXT, node="views"))
    for seq in (0, 1, 2):
        hub.publish(FRAME, frame_of(seq))
        hub.publish(MASK, masks_of(seq))
    hub.run()

    def shown():
        sets = views._selector.view_sets()
        return {s.instance_id: {v.seq: v.visible_px for v in s.views} for s in sets}

    before = shown()
    hub.publish(POSE_CORRECTION, right(0, 1, 2))
    hub.run()
    views.step(None)
    after = shown()
    assert before.keys() == after.keys() != set()
    for instance_id, views_before in before.items():
        for seq, visible_px in views_before.items():
            assert after[instance_id][seq] == pytest.approx(visible_px, rel=0.1)
    assert hub.bus(mapping).counters["corrections_applied"] == 1


class Told(Ingestor):
    """Finds, at its third frame, that the first one was elsewhere."""

    def ingest(self, raw):
        ingested = super().ingest(raw)
        if isinstance(ingested, Ingested) and raw.seq == 2:
            return replace(ingested, corrected={0: SHIFT})
        return ingested


def test_ingest_tells_corrections_before_the_keyframe(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("sceneq_nodes._ingesting.Ingestor", Told)
    source = {"kind": "folder", "path": str(write_folder(tmp_path / "shelf", [0, 1, 2]))}
    every = {"kind": "every", "every": 1}
    bus = FakeBus()
    node = Ingest(IngestParams(source=source, keyframes=every, rate_hz=1e6, wait_for=()), CONTEXT)
    node.open(bus)
    for _ in range(5):
        node.step(None)
    (told,) = bus.sent(POSE_CORRECTION)
    assert (told.seq, told.full, told.frame_seq, told.keyframe_seq.tolist()) == (1, True, 2, [0])
    np.testing.assert_array_equal(told.T_world_camera, SHIFT[None])
    order = [(p.topic.name, p.message.seq) for p in bus.published if p.topic.name != "pose"]
    assert order == [("frame", 0), ("frame", 1), ("correction", 1), ("frame", 2)]
    assert bus.counters["corrections"] == 1


def test_a_keyframe_that_comes_again_brings_its_correction(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """Mapping may have been dead when both were told; who had heard it knows it by its content."""
    monkeypatch.setattr("sceneq_nodes._ingesting.Ingestor", Told)
    source = {"kind": "folder", "path": str(write_folder(tmp_path / "shelf", [0, 1, 2]))}
    every = {"kind": "every", "every": 1}
    bus = FakeBus()
    node = Ingest(IngestParams(source, keyframes=every, wait_for=()), CONTEXT)
    node.open(bus)
    for seq in (0, 1):
        node.step(None)
        bus.deliver(node, VIEW_DELTA, ViewDelta(1, seq + 1, False, seq, 0, 1, 1, ()))
    node.step(None)
    node._resend(time.monotonic() + 10.0)
    order = [(p.topic.name, p.message.seq) for p in bus.published if p.topic.name != "pose"]
    assert order[-4:] == [("correction", 1), ("frame", 2)] * 2
    assert bus.counters["frames_resent"] == 1


def test_a_lost_camera_is_counted(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    source = {
        "kind": "folder",
        "path": str(write_folder(tmp_path / "shelf", [0, 1])),
        "use_poses": False,
    }
    odometry = {"kind": "depth_icp", "min_points": 10_000_000}
    bus = FakeBus()
    node = Ingest(IngestParams(source, odometry=odometry, rate_hz=1e6, wait_for=()), CONTEXT)
    node.open(bus)
    for _ in range(4):
        node.step(None)
    assert bus.counters["frames_skipped"] == bus.counters["tracking_lost"] == 2
    assert "frame 1 skipped: depth_icp: no pose: tracking lost" in caplog.text
