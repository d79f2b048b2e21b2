"""Whatever the order and the portions, the same observations make the same map."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.mapping.mapper import Mapper
from sceneq_core.mapping.partition import SuperpointParams, VoxelFeatures, partition
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.mapping.superpoints import Superpoints
from sceneq_core.mapping.surface import SurfacePoints
from sceneq_core.mapping.voxel_index import VoxelIndex
from sceneq_core.mapping.voxels import Voxels

from support.surfaces import SMALL, room_frames

NOTHING = np.zeros(0, np.int32)
PARAMS = SuperpointParams(refresh_keyframes=1, min_growth=1.0)
VIEWS = room_frames(5)


def random_surface(seed, count):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.3, 0.3, (count, 3)) * (1.0, 1.0, 0.1)
    normals = rng.normal((0.0, 0.0, 1.0), 0.2, (count, 3))
    return SurfacePoints(
        points_world=points,
        normals_world=normals / np.linalg.norm(normals, axis=1, keepdims=True),
        rgb=np.where(points[:, :1] > 0, [200, 30, 30], [90, 90, 90]).astype(np.uint8),
        weight=rng.uniform(0.1, 1.0, count),
        row=np.zeros(count, np.int32),
        column=np.zeros(count, np.int32),
    )


def part_of(surface, rows):
    return SurfacePoints(*(getattr(surface, name)[rows] for name in SurfacePoints.__slots__))


portions = st.lists(st.integers(1, 400), min_size=1, max_size=5)


def by_coord(voxels):
    ids = np.arange(len(voxels), dtype=np.int32)
    coord = voxels.coord(ids)
    return ids[np.lexsort(coord.T)]


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), sizes=portions)
def test_voxels_and_superpoints_streamed_equal_batch(seed, sizes):
    surface = random_surface(seed, sum(sizes))
    batch, streamed = Voxels(0.02), Voxels(0.02)
    superpoints = Superpoints(PARAMS)
    batch.integrate(surface)
    rows = np.random.default_rng(seed).permutation(sum(sizes))
    for keyframe, portion in enumerate(np.split(rows, np.cumsum(sizes)[:-1])):
        touched = streamed.integrate(part_of(surface, portion))
        superpoints.update(streamed, touched.voxel_id, NOTHING, keyframe)
    one, other = by_coord(batch), by_coord(streamed)
    assert np.array_equal(batch.coord(one), streamed.coord(other))
    assert np.allclose(batch.points_world(one), streamed.points_world(other), atol=1e-9)
    assert np.allclose(batch.normals_world(one), streamed.normals_world(other), atol=1e-6)
    assert_same_partition(partition_of(batch, one), superpoints.of(other))


def partition_of(voxels, voxel_id):
    """Return the superpoints of all voxels partitioned at once, in the order of ``voxel_id``."""
    inside = voxels.cells.voxels(np.arange(len(voxels.cells), dtype=np.int32))
    part = np.empty(len(voxels), np.int32)
    part[inside] = partition(
        VoxelFeatures(voxels.coord(inside), *voxels.features(inside)),
        PARAMS,
    )
    return part[voxel_id]


def assert_same_partition(one, other):
    pairs = set(zip(one.tolist(), other.tolist(), strict=True))
    assert len(pairs) == len(set(one.tolist())) == len(set(other.tolist()))


@settings(max_examples=50, deadline=None)
@given(
    st.lists(
        st.lists(st.tuples(*[st.integers(-20, 20)] * 3), min_size=1, max_size=60),
        min_size=1,
        max_size=6,
    )
)
def test_a_voxel_index_is_a_dictionary(batches):
    index, model = VoxelIndex(), {}
    for batch in batches:
        for coord in sorted(set(batch) - model.keys()):
            model[coord] = len(model)
        assert index.insert(np.array(batch, np.int32)).tolist() == [model[c] for c in batch]
    known = np.array(list(model), np.int32)
    assert index.lookup(known).tolist() == list(model.values())
    assert len(index) == len(model)


@settings(max_examples=4, deadline=None)
@given(order=st.permutations(range(len(VIEWS))), repeat=st.integers(0, 2))
def test_any_order_of_frames_replays_from_its_deltas(order, repeat):
    mapper, replica = Mapper(SMALL), MapReplica()
    ids = set()
    for view in (*order, *order[:repeat]):
        delta = mapper.integrate(*VIEWS[view])
        replica.apply(delta)
        ids |= {i.instance_id for i in delta.instances}
    whole = MapReplica()
    whole.apply(mapper.snapshot())
    for one, other in zip(replica.cloud(), whole.cloud(), strict=True):
        assert np.array_equal(one, other)
    assert replica.instances.keys() == whole.instances.keys()
    assert ids == set(range(1, len(ids) + 1))
    owned = [s for i in whole.instances.values() for s in i.superpoint_id.tolist()]
    assert len(owned) == len(set(owned))


@settings(max_examples=4, deadline=None)
@given(order=st.permutations(range(len(VIEWS))))
def test_the_order_of_frames_does_not_change_the_things_found(order):
    mapper = Mapper(SMALL)
    for view in order:
        mapper.integrate(*VIEWS[view])
    centres = centres_of(mapper)
    gaps = np.linalg.norm(centres[:, None] - REFERENCE[None], axis=2)
    assert gaps.shape == (len(REFERENCE), len(REFERENCE))
    assert gaps.min(axis=0).max() < 0.2


def centres_of(mapper):
    return np.array([i.centre_world for i in mapper.snapshot().instances])


def _reference():
    mapper = Mapper(SMALL)
    for frame, instance in VIEWS:
        mapper.integrate(frame, instance)
    return centres_of(mapper)


REFERENCE = _reference()
