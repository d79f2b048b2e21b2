"""The whole map on a small ray-cast room with true segments."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.boxes import box_around
from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.mapper import Mapper, MapperParams
from sceneq_core.mapping.replica import MapReplica

from support.room import THINGS
from support.surfaces import SMALL, flat_frame, room_frames

VIEWS = room_frames(6)
UP = np.array([0.0, 0.0, 1.0])


def grown(views=VIEWS, params=SMALL):
    mapper = Mapper(params)
    deltas = [mapper.integrate(frame, instance) for frame, instance in views]
    return mapper, deltas


def digest(delta):
    replica = MapReplica()
    replica.apply(delta)
    points, _, instance_id = replica.cloud()
    coord = np.floor(points / delta.voxel_size_m).astype(np.int32)
    return map_digest(coord, points, instance_id)


def nearest(snapshot, name):
    thing = next(t for t in THINGS if t.name == name)
    gaps = [np.linalg.norm(i.centre_world - thing.centre) for i in snapshot.instances]
    return snapshot.instances[int(np.argmin(gaps))], thing


def test_every_thing_becomes_one_instance_of_its_size():
    snapshot = grown()[0].snapshot()
    assert len(snapshot.instances) == len(THINGS)
    for name in ("blue box", "green box"):
        instance, thing = nearest(snapshot, name)
        assert np.abs(instance.aabb_world.mean(axis=0) - thing.centre).max() < 0.06
        assert np.abs(np.sort(instance.box_size_m) - np.sort(thing.size)).max() < 0.07


def test_gravity_is_found():
    assert grown()[0].snapshot().up_world @ UP > 0.999


def test_ids_start_at_one_and_keep_meaning_the_same_thing():
    _, deltas = grown()
    first = {}
    for delta in deltas:
        for instance in delta.instances:
            origin = first.setdefault(instance.instance_id, instance.centre_world)
            assert instance.instance_id >= 1
            if instance.voxel_count < 2000:
                assert np.linalg.norm(instance.centre_world - origin) < 0.15
    assert sorted(first) == list(range(1, len(first) + 1))
    assert len(first) >= 3


def test_deltas_replay_to_the_snapshot():
    mapper, deltas = grown()
    replica, whole = MapReplica(), MapReplica()
    for delta in deltas:
        replica.apply(delta)
    whole.apply(mapper.snapshot())
    for one, other in zip(replica.cloud(), whole.cloud(), strict=True):
        assert np.array_equal(one, other)
    assert replica.instances.keys() == whole.instances.keys()


def test_the_same_frames_give_the_same_bits():
    assert digest(grown()[0].snapshot()) == digest(grown()[0].snapshot())


def test_a_digest_ignores_row_order_and_sees_one_bit():
    coord = np.array([[1, 0, 0], [0, 0, 1]], np.int32)
    points = coord.astype(np.float32)
    instance_id = np.array([1, 2], np.int32)
    whole = map_digest(coord, points, instance_id)
    assert map_digest(coord[::-1], points[::-1], instance_id[::-1]) == whole
    assert map_digest(coord, points, instance_id[::-1]) != whole


def test_a_frame_without_depth_or_segments_changes_nothing():
    mapper, _ = grown(VIEWS[:2])
    before = digest(mapper.snapshot())
    empty = mapper.integrate(flat_frame(0.0, seq=90), np.zeros((60, 80), np.uint16))
    assert (len(empty.voxel_id), len(empty.instances), empty.frame_seq) == (0, 0, 90)
    assert digest(mapper.snapshot()) == before


def test_an_empty_map_has_an_empty_snapshot():
    snapshot = Mapper(MapperParams()).snapshot()
    assert snapshot.full
    assert (len(snapshot.voxel_id), snapshot.instances, snapshot.frame_seq) == (0, (), -1)


def test_a_thing_that_was_taken_away_disappears():
    table = np.full((60, 80), 2.0, np.float32)
    with_box = table.copy()
    with_box[20:40, 30:50] = 1.5
    label = np.ones((60, 80), np.uint16)
    label[20:40, 30:50] = 2
    mapper = Mapper(SMALL)
    for seq in range(3):
        mapper.integrate(flat_frame(with_box, seq), label)
    assert [i.instance_id for i in mapper.snapshot().instances] == [1, 2]
    deltas = [mapper.integrate(flat_frame(table, seq), np.ones_like(label)) for seq in range(3, 7)]
    assert sum(len(delta.removed_voxel_id) for delta in deltas) > 100
    states = [(i.instance_id, i.state) for delta in deltas for i in delta.instances]
    assert (2, "removed") in states
    assert [i.instance_id for i in mapper.snapshot().instances] == [1]


def test_a_wrong_size_or_pose_is_refused_and_leaves_the_map_as_it_was():
    mapper, _ = grown(VIEWS[:2])
    before = digest(mapper.snapshot())
    frame, instance = VIEWS[2]
    bad_pose = frame.T_world_camera.copy()
    bad_pose[0, 3] = np.nan
    with pytest.raises(ValueError, match=r"label_image: expected \(120, 160\), got \(60, 80\)"):
        mapper.integrate(frame, np.zeros((60, 80), np.uint16))
    with pytest.raises(ValueError, match="T_world_camera: not finite in frame 2"):
        mapper.integrate(replace(frame, T_world_camera=bad_pose), instance)
    far = frame.T_world_camera.copy()
    far[0, 3] = 1e6
    with pytest.raises(ValueError, match="voxel coordinate outside"):
        Mapper(SMALL).integrate(replace(frame, T_world_camera=far), instance)
    assert digest(mapper.snapshot()) == before


def test_counts_follow_the_snapshot():
    mapper, _ = grown(VIEWS[:4])
    snapshot = mapper.snapshot()
    assert mapper.counts() == {
        "voxels": len(snapshot.voxel_id),
        "instances": len(snapshot.instances),
    }


@pytest.mark.parametrize("field", ["voxel_size_m", "min_superpoint_pixels", "publish_step_m"])
def test_a_bad_parameter_is_named(field):
    with pytest.raises(ValueError, match=f"^{field}: "):
        MapperParams(**{field: -1})


def box_points(turn_deg, size=(1.0, 0.4, 0.2)):
    grid = [np.linspace(-s / 2, s / 2, 9) for s in size]
    corner = np.stack(np.meshgrid(*grid), axis=-1).reshape(-1, 3)
    c, s = np.cos(np.deg2rad(turn_deg)), np.sin(np.deg2rad(turn_deg))
    turned = corner @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return (turned + np.array([1.0, 2.0, 3.0])).astype(np.float32)


def test_the_oriented_box_finds_the_turn_and_the_size():
    box = box_around(box_points(30.0), UP)
    assert box.box_size_m == pytest.approx([1.0, 0.4, 0.2], abs=1e-4)
    assert box.T_world_box[:3, 3] == pytest.approx([1.0, 2.0, 3.0], abs=1e-4)
    assert box.T_world_box[:3, 2] == pytest.approx(UP)
    assert abs(box.T_world_box[:3, 0] @ [np.cos(np.pi / 6), 0.5, 0]) == pytest.approx(1, abs=1e-4)
    assert np.linalg.det(box.T_world_box[:3, :3]) == pytest.approx(1.0)


def test_the_oriented_box_stands_along_gravity_whatever_the_world():
    points = box_points(30.0)[:, [0, 2, 1]] * np.float32([1, -1, 1])
    box = box_around(points, np.array([0.0, -1.0, 0.0]))
    assert box.box_size_m == pytest.approx([1.0, 0.4, 0.2], abs=1e-4)
    assert box.aabb_world[1] - box.aabb_world[0] == pytest.approx(np.ptp(points, axis=0))
