"""What a user may rely on: dropped, shuffled and broken keyframes do not change what is found.

Properties of the whole ``Mapper`` on a small room with clean segments.
"""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.mapper import Mapper
from sceneq_core.mapping.replica import MapReplica

from support.room import THINGS
from support.surfaces import SMALL, room_frames

VIEWS = room_frames(8)
few = settings(max_examples=4, deadline=None)


def grown(views):
    """Return the mapper and the replica that followed it."""
    mapper, replica = Mapper(SMALL), MapReplica()
    for view in views:
        replica.apply(mapper.integrate(*view))
    return mapper, replica


def digest(replica):
    points, _, instance_id = replica.cloud()
    return map_digest(np.floor(points / replica.voxel_size_m).astype(np.int32), points, instance_id)


def partition_of(replica):
    """Return the instance of each voxel coordinate."""
    alive = np.flatnonzero(replica.alive)
    coord, instance_id = replica.voxel_coord[alive], replica.instance_of_voxel()[alive]
    return dict(zip(map(tuple, coord.tolist()), instance_id.tolist(), strict=True))


def disagreement(one, other):
    """Return the share of common voxels outside the largest overlap of each instance of ``one``."""
    common = sorted(one.keys() & other.keys())
    pairs = np.array([(one[c], other[c]) for c in common])
    both, count = np.unique(pairs, axis=0, return_counts=True)
    by_one = dict.fromkeys(pairs[:, 0].tolist(), 0)
    for a, n in zip(both[:, 0].tolist(), count.tolist(), strict=True):
        by_one[a] = max(by_one[a], n)
    return 1.0 - sum(by_one.values()) / len(common)


def things_found(replica):
    """Return, for every thing, whether one instance lies where it is."""
    centres = [instance.centre_world for instance in replica.instances.values()]
    return {
        thing.name: min(np.linalg.norm(c - thing.centre) for c in centres) < 0.2
        for thing in THINGS[3:]
    }


def bad(view, fault, direction):
    frame, labels = view
    depth_m, rgb, pose = (getattr(frame, n).copy() for n in ("depth_m", "rgb", "T_world_camera"))
    if fault == "nan":
        depth_m[::3, ::5] = np.nan
    elif fault == "black":
        rgb[:, :80] = 0
    elif fault == "empty":
        depth_m[:, 1:] = 0
    else:
        pose[:3, 3] += 5.0 * np.array(direction) / np.linalg.norm(direction)
    return replace(frame, depth_m=depth_m, rgb=rgb, T_world_camera=pose), labels


faults = st.sampled_from(["nan", "black", "empty", "pose"])
directions = st.sampled_from([(1, 0, 0), (-1, 0, 1), (0, 1, 0), (0, -1, 0), (0, 0, 1), (1, 1, -1)])
CLEAN = grown(VIEWS)[1]


@few
@given(order=st.permutations(range(len(VIEWS))))
def test_shuffled_keyframes_end_in_the_same_partition(order):
    _, replica = grown([VIEWS[i] for i in order])
    assert len(replica.instances) == len(CLEAN.instances)
    assert disagreement(partition_of(CLEAN), partition_of(replica)) < 0.02


@few
@given(start=st.integers(0, 1), every=st.integers(1, 2))
def test_with_half_of_the_keyframes_the_same_things_are_found(start, every):
    _, replica = grown(VIEWS[start::every])
    assert things_found(replica) == dict.fromkeys((t.name for t in THINGS[3:]), True)
    assert len(replica.instances) == len(CLEAN.instances)
    assert disagreement(partition_of(CLEAN), partition_of(replica)) < 0.05


@settings(max_examples=6, deadline=None)
@given(at=st.integers(1, 6), fault=faults, direction=directions)
def test_a_bad_keyframe_leaves_the_map_of_a_run_without_it(at, fault, direction):
    _, replica = grown([*VIEWS[:at], bad(VIEWS[at], fault, direction), *VIEWS[at + 1 :]])
    _, without = grown([*VIEWS[:at], *VIEWS[at + 1 :]])
    assert digest(replica) == digest(without)


@few
@given(spoiled=st.dictionaries(st.integers(1, 7), st.tuples(faults, directions), max_size=4))
def test_a_replica_is_the_map_whatever_is_kept_out_or_let_in(spoiled):
    views = [bad(v, *spoiled[i]) if i in spoiled else v for i, v in enumerate(VIEWS)]
    mapper, replica = grown(views)
    whole = MapReplica()
    whole.apply(mapper.snapshot())
    assert digest(replica) == digest(whole)
    assert replica.instances.keys() == whole.instances.keys()
    for instance_id, instance in whole.instances.items():
        told = replica.instances[instance_id]
        assert np.array_equal(told.superpoint_id, instance.superpoint_id)
        assert (told.state, told.voxel_count) == (instance.state, instance.voxel_count)


def test_the_same_keyframes_give_the_same_bits():
    assert digest(grown(VIEWS)[1]) == digest(CLEAN)
