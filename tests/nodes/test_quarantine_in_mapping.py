"""Bad keyframes and external proposals on their way through the mapping node."""

import logging
from dataclasses import replace

import numpy as np

from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._images import frame_message
from sceneq_nodes.mapping import Mapping, MappingParams
from sceneq_schemas.mask import Masks
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.topics import FRAME, MAP_DELTA, MASK, PROPOSAL

from support.fake_bus import FakeBus
from support.surfaces import SMALL, room_frames

VIEWS = room_frames(6)


def opened(**params):
    bus = FakeBus()
    node = Mapping(MappingParams(mapper=SMALL, **params), bus.context)
    node.open(bus)
    return node, bus


def show(node, bus, *views):
    for frame, labels in views:
        bus.deliver(node, FRAME, frame_message(frame, "raw", "raw"))
        bus.deliver(node, MASK, Masks(frame.seq, frame.stamp_ns, labels))


def black(view):
    frame, labels = view
    return replace(frame, rgb=np.zeros_like(frame.rgb)), labels


def displaced(view, metres):
    frame, labels = view
    T_world_camera = frame.T_world_camera.copy()
    T_world_camera[:3, 3] += metres
    return replace(frame, T_world_camera=T_world_camera), labels


def digest(bus):
    replica = MapReplica()
    for delta in bus.sent(MAP_DELTA):
        replica.apply(map_delta_from_message(delta))
    points, _, instance_id = replica.cloud()
    return map_digest(np.floor(points / replica.voxel_size_m).astype(np.int32), points, instance_id)


def test_a_bad_keyframe_is_counted_named_and_logged_once_per_kind(caplog):
    node, bus = opened()
    with caplog.at_level(logging.WARNING):
        show(node, bus, VIEWS[0], black(VIEWS[1]), black(VIEWS[2]), displaced(VIEWS[3], 30.0))
    assert bus.counters == {"frames_integrated": 1, "frames_quarantined": 3}
    deltas = bus.sent(MAP_DELTA)
    assert [d.frame_seq for d in deltas] == [0, 1, 2, 3]
    assert [d.quarantined.partition(":")[0] for d in deltas] == [
        "",
        "colour black",
        "colour black",
        "pose jumped",
    ]
    assert [record.getMessage().split(":")[0] for record in caplog.records] == [
        "frame 1 kept out of the map, camera at [-0.74, -1.28, 1.5]",
        "frame 3 kept out of the map, camera at [30.25, 28.61, 31.5]",
    ]


def test_the_map_is_the_same_as_without_the_bad_keyframe():
    node, bus = opened()
    show(node, bus, *VIEWS[:3], displaced(VIEWS[3], (0.0, 5.0, 0.0)), *VIEWS[4:])
    other, other_bus = opened()
    show(other, other_bus, *VIEWS[:3], *VIEWS[4:])
    assert bus.counters["frames_quarantined"] == 1
    assert digest(bus) == digest(other_bus)


def proposed(points, pairs):
    mask_id, point_id = np.array(pairs, np.int32).T
    return ProposalSet(
        stamp_ns=0,
        source="somebody",
        points_world=points,
        mask_id=np.ascontiguousarray(mask_id),
        point_id=np.ascontiguousarray(point_id),
        score=np.ones(1, np.float32),
    )


def test_masks_over_the_bus_are_taken_or_refused():
    node, bus = opened()
    points = np.zeros((2, 3), np.float32)
    bus.deliver(node, PROPOSAL, proposed(points, [(0, 0), (0, 1)]))
    bus.deliver(node, PROPOSAL, proposed(points, [(0, 0), (0, 7)]))
    assert bus.counters == {"proposals_taken": 1, "proposals_refused": 1}


def test_masks_from_a_file_are_there_before_the_first_keyframe(tmp_path):
    show(*(plain := opened()), *VIEWS[:5])
    delta = map_delta_from_message(plain[1].sent(MAP_DELTA)[0])
    box = np.abs(delta.points_world - (0.3, 1.0, 0.82)).max(axis=1) < 0.13
    points = delta.points_world[box]
    path = tmp_path / "masks.npz"
    np.savez(path, points_world=points, instance=np.ones(len(points), int))
    node, bus = opened(proposals={"kind": "file", "path": str(path)})
    show(node, bus, *VIEWS[:5])
    assert digest(bus) != digest(plain[1])
