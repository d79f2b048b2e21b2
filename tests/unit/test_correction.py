"""The map when the poses it was made with are corrected."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from sceneq_core.ingest.transforms import inverse, rotation_of
from sceneq_core.mapping.correction import (
    Anchors,
    Correction,
    CorrectionParams,
    absorbed,
)
from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.mapper import Mapper
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.mapping.voxels import Voxels

from support.room import Room
from support.surfaces import SMALL, patch, room_frames, surface

VIEWS = room_frames(4, Room(size=(96, 72), focal_px=78.0))
EVERYTHING = [*VIEWS, *VIEWS[::-1]]


def moved(t=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0)):
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = rotation_of(np.array(turn)), t
    return motion


def stream(errors):
    """Return the room's frames, there and back, each at its pose times an error."""
    return [
        (replace(frame, seq=i, T_world_camera=error @ frame.T_world_camera), instance)
        for i, ((frame, instance), error) in enumerate(zip(EVERYTHING, errors, strict=True))
    ]


def grown(frames):
    mapper, replica = Mapper(SMALL), MapReplica()
    for frame, instance in frames:
        replica.apply(mapper.integrate(frame, instance))
    return mapper, replica


def correction(frames):
    return Correction(
        np.array([frame.seq for frame, _ in frames], np.int64),
        np.array([frame.T_world_camera for frame, _ in frames]),
    )


def digest(replica):
    coord = replica.voxel_coord[replica.alive]
    points = replica.points_world[replica.alive]
    return map_digest(coord, points, replica.instance_of_voxel()[replica.alive])


def reach(one, other):
    """Return how far 99 of 100 points of ``one`` are from a point of ``other``, at most."""
    return float(np.percentile(cKDTree(other).query(one)[0], 99))


STILL = [np.eye(4)] * len(EVERYTHING)
JUMP = [np.eye(4)] * len(VIEWS) + [moved((0.09, -0.05, 0.02), (0, 0, 0.03))] * len(VIEWS)


def test_the_same_poses_change_nothing():
    mapper, replica = grown(stream(STILL))
    before = digest(replica)
    delta = mapper.correct(correction(stream(STILL)))
    assert (delta.full, len(delta.voxel_id), delta.instances) == (False, 0, ())
    replica.apply(delta)
    replica.apply(mapper.snapshot())
    assert digest(replica) == before


def test_frames_that_are_not_in_the_map_are_left_out():
    mapper, _ = grown(stream(STILL)[:2])
    assert not mapper.correct(Correction(np.array([77]), moved((1.0, 0, 0))[None])).full


def test_a_room_that_was_mapped_twice_comes_together():
    right, wrong = stream(STILL), stream(JUMP)
    _, truth = grown(right)
    mapper, replica = grown(wrong)
    ids = set(replica.instances)
    doubled = replica.alive.sum()
    assert doubled > 1.2 * truth.alive.sum()
    delta = mapper.correct(correction(right))
    replica.apply(delta)
    assert delta.full
    assert replica.alive.sum() < 1.1 * truth.alive.sum() < doubled
    points, true_points = replica.points_world[replica.alive], truth.points_world[truth.alive]
    assert max(reach(points, true_points), reach(true_points, points)) < 0.02
    # No instance is new, none is there twice, and what was merged says into what.
    assert set(replica.instances) <= ids
    assert len(replica.instances) == len(truth.instances)
    gone = [i for i in delta.instances if i.state == "removed"]
    assert {i.instance_id for i in gone} == ids - set(replica.instances)
    assert all(i.merged_into in replica.instances for i in gone)
    for true in truth.instances.values():
        apart = [np.abs(i.aabb_world - true.aabb_world).max() for i in replica.instances.values()]
        assert min(apart) < 0.08


def test_the_delta_says_where_surface_went():
    wrong = [moved((0.1, 0.0, 0.0))] * len(EVERYTHING)
    mapper, replica = grown(stream(wrong))
    before = replica.voxel_coord.copy()
    count = int(replica.alive.sum())
    delta = mapper.correct(correction(stream(STILL)))
    replica.apply(delta)
    step = replica.voxel_coord[delta.moved_to_id] - before[delta.moved_from_id]
    assert len(delta.moved_from_id) == count
    # But for rounding, where a mean lies just between two voxels.
    assert np.mean((step == (-5, 0, 0)).all(axis=1)) > 0.99
    assert replica.alive.sum() > 0.99 * count


def test_the_map_goes_on_after_a_correction():
    right, wrong = stream(STILL), stream(JUMP)
    mapper, _ = grown(wrong)
    first = mapper.correct(correction(right))
    again = mapper.correct(correction(right))
    assert (first.full, again.full) == (True, False)
    replica = MapReplica()
    replica.apply(first)
    for frame, instance in right[:3]:
        replica.apply(mapper.integrate(replace(frame, seq=frame.seq + 100), instance))
    whole = MapReplica()
    whole.apply(mapper.snapshot())
    assert digest(whole) == digest(replica)


def test_the_same_corrections_give_the_same_bits():
    def run():
        mapper, replica = grown(stream(JUMP))
        replica.apply(mapper.correct(correction(stream(STILL))))
        return digest(replica)

    assert run() == run()


@pytest.mark.parametrize(
    ("poses", "reason"),
    [
        (np.eye(4)[None], "for 2 frames"),
        (np.full((2, 4, 4), np.nan), "not finite"),
        (np.tile(2 * np.eye(4), (2, 1, 1)), "not rigid"),
        (np.tile(moved((1e9, 0, 0)), (2, 1, 1)), "voxel coordinate outside"),
    ],
)
def test_nonsense_is_refused_and_changes_nothing(poses, reason):
    mapper, replica = grown(stream(STILL)[:3])
    with pytest.raises(ValueError, match=reason):
        mapper.correct(Correction(np.array([0, 1]), poses))
    whole = MapReplica()
    whole.apply(mapper.snapshot())
    assert digest(whole) == digest(replica)


def test_a_voxel_keeps_the_anchor_that_first_saw_it_and_moves_with_its_sums():
    voxels = Voxels(0.02)
    first = voxels.integrate(surface(patch((0, 0.1), (0, 0.1), 1.0)), 3)
    voxels.integrate(surface(patch((0, 0.2), (0, 0.1), 1.0)), 5)
    assert set(voxels.anchor[first.voxel_id]) == {3}
    every = np.arange(len(voxels), dtype=np.int32)
    assert set(voxels.anchor[every]) == {3, 5}
    before = voxels.points_world(every)
    to = voxels.move(every, np.tile(moved((0.5, 0, 0)), (len(every), 1, 1))).to_id
    np.testing.assert_allclose(voxels.points_world(to), before + np.array([0.5, 0, 0]), atol=1e-12)
    assert not len(voxels.occupied(every))


def test_where_two_surfaces_meet_the_heavier_one_names_the_place():
    voxels = Voxels(0.02)
    light = voxels.integrate(surface([(0.01, 0.01, 0.01)], weight=1.0), 1).voxel_id
    heavy = voxels.integrate(surface([(0.11, 0.01, 0.01)], weight=5.0), 2).voxel_id
    moves = voxels.move(heavy, moved((-0.1, 0, 0))[None])
    assert (moves.to_id.tolist(), moves.heaviest.tolist()) == (light.tolist(), [0])
    assert voxels.anchor[light].tolist() == [2]
    lighter = voxels.integrate(surface([(0.11, 0.01, 0.01)], weight=1.0), 4).voxel_id
    assert not len(voxels.move(lighter, moved((-0.1, 0, 0))[None]).heaviest)


def test_a_seq_named_twice_has_its_last_pose():
    anchors = Anchors()
    anchors.add(4, np.eye(4))
    twice = Correction(np.array([4, 4]), np.array([moved((1, 0, 0)), moved((2, 0, 0))]))
    np.testing.assert_array_equal(anchors.motions(twice).T_new_old[0], moved((2, 0, 0)))
    anchors.take(twice)
    assert not anchors.motions(Correction(np.array([4]), moved((2, 0, 0))[None])).moved.any()
    back = anchors.motions(Correction(np.array([4]), np.eye(4)[None]))
    np.testing.assert_allclose(back.T_new_old[0], inverse(moved((2, 0, 0))))


def test_what_is_swallowed_by_another_group_is_the_same_thing():
    before = np.array([0] * 10 + [1] * 10 + [2] * 10 + [3] * 10 + [-1] * 5, np.int32)
    parts = [[0] * 10, [1] * 7 + [0] * 3, [0] * 5 + [2] * 4 + [-1], [1] * 9 + [3], [0] * 5]
    after = np.array([group for part in parts for group in part], np.int32)
    found = absorbed(before, after, CorrectionParams())
    assert (found.group.tolist(), found.into.tolist()) == ([2, 3], [0, 1])
    assert found.sure.tolist() == [False, True]
    assert not len(absorbed(before, before, CorrectionParams()).group)
    assert absorbed(before, after, CorrectionParams(min_share=0.3)).group.tolist() == [1, 2, 3]
