"""A reader's copy of the map follows the deltas and refuses those that contradict themselves."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.replica import MapReplica

from support.true_map import delta, instance, voxels


@pytest.fixture
def replica() -> MapReplica:
    """Voxels 0..3 in superpoints 0, 0, 1, none; instance 7 owns superpoint 0."""
    replica = MapReplica()
    replica.apply(delta(**voxels(range(4), (0, 0, 1, -1)), instances=(instance(7, [0]),)))
    return replica


def test_voxels_belong_to_the_instance_of_their_superpoint(replica):
    assert replica.instance_of_voxel().tolist() == [7, 7, 0, 0]
    assert replica.instance_of_voxel().dtype == np.int32


def test_a_superpoint_moves_to_another_instance_in_either_order(replica):
    taken, left = instance(8, [0, 1]), instance(7, [])
    for instances in ((taken, left), (left, taken)):
        replica.apply(delta(instances=instances))
        assert replica.instance_of_voxel().tolist() == [8, 8, 8, 0]


def test_a_removed_instance_owns_nothing(replica):
    replica.apply(delta(instances=(instance(7, [0], state="removed", merged_into=8),)))
    assert replica.instances == {}
    assert replica.instance_of_voxel().tolist() == [0, 0, 0, 0]


def test_a_tentative_instance_is_known_but_owns_nothing_until_it_is_confirmed(replica):
    for state, owners in (("tentative", [7, 7, 0, 0]), ("confirmed", [7, 7, 8, 0])):
        replica.apply(delta(instances=(instance(8, [1], state=state),)))
        assert sorted(replica.instances) == [7, 8]
        assert replica.instance_of_voxel().tolist() == owners


def test_an_instance_may_come_before_its_voxels(replica):
    replica.apply(delta(instances=(instance(9, [5]),)))
    replica.apply(delta(**voxels([4], [5])))
    assert replica.instance_of_voxel().tolist() == [7, 7, 0, 0, 9]


def test_a_removed_voxel_is_dead_until_it_is_written_again(replica):
    replica.apply(delta(removed_voxel_id=np.array([1], np.int32)))
    assert replica.alive.tolist() == [True, False, True, True]
    assert replica.instance_of_voxel().tolist() == [7, 0, 0, 0]
    replica.apply(delta(**voxels([1], [0])))
    assert replica.instance_of_voxel().tolist() == [7, 7, 0, 0]


def test_the_cloud_is_sorted_by_coordinate_whatever_the_ids():
    columns = voxels(range(3), (0, 1, 2))
    columns["voxel_coord"] = np.array([[1, 0, 0], [0, 5, 0], [0, -5, 9]], np.int32)
    replica = MapReplica()
    replica.apply(delta(**columns, instances=(instance(4, [2]),)))
    points, rgb, instance_id = replica.cloud()
    assert np.array_equal(points, columns["points_world"][[2, 1, 0]])
    assert instance_id.tolist() == [4, 0, 0]
    assert rgb.shape == (3, 3)


def test_a_full_delta_replaces_everything(replica):
    replica.apply(delta(full=True, frame_seq=9, **voxels([0], [3])))
    assert replica.voxel_count == 1
    assert replica.instances == {}
    assert replica.frame_seq == 9


def test_deltas_add_up_to_the_snapshot():
    step_by_step, at_once = MapReplica(), MapReplica()
    for i in range(50):
        step_by_step.apply(delta(**voxels([i], [i // 10]), instances=(instance(1, [i // 10]),)))
    final = instance(1, [4])
    at_once.apply(
        delta(full=True, **voxels(range(50), [i // 10 for i in range(50)]), instances=(final,))
    )
    for a, b in zip(step_by_step.cloud(), at_once.cloud(), strict=True):
        assert np.array_equal(a, b)


@pytest.mark.parametrize(
    ("field", "value", "complaint"),
    [
        ("rgb", np.zeros((3, 3), np.uint8), "columns of different length"),
        ("voxel_id", np.array([0, -1], np.int32), "voxel_id -1..0"),
        ("voxel_coord", np.full((2, 3), 1 << 20, np.int32), "voxel_coord"),
        ("superpoint_id", np.array([0, -2], np.int32), "superpoint_id -2..0"),
        ("removed_voxel_id", np.array([4], np.int32), "removed_voxel_id 4..4"),
        ("moved_to_id", np.array([1], np.int32), "moved_from_id and moved_to_id differ"),
        ("voxel_size_m", 0.0, "voxel_size_m"),
        ("instances", (instance(0, []),), "instance 0"),
        ("instances", (instance(1, [], state="asleep"),), "'asleep'"),
        ("instances", (instance(1, [-1]),), "instance.superpoint_id -1..-1"),
    ],
)
def test_a_delta_that_contradicts_itself_changes_nothing(replica, field, value, complaint):
    before = replica.cloud()
    bad = replace(delta(frame_seq=5, **voxels([0, 1], [2, 2])), **{field: value})
    with pytest.raises(ValueError, match=complaint):
        replica.apply(bad)
    assert all(np.array_equal(a, b) for a, b in zip(before, replica.cloud(), strict=True))
    assert replica.frame_seq == 0
