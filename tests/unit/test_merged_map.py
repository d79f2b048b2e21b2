"""Several changes of a map told as one make the same replica as one after the other."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.mapping.delta import CONFIRMED, REMOVED, Instance, MapDelta
from sceneq_core.mapping.merged import merged
from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._convert import map_delta_from_message
from sceneq_schemas.map import MapDelta as Message

from support.messages import EXAMPLES

EXAMPLE = map_delta_from_message(next(one for one in EXAMPLES if isinstance(one, Message)))
NONE = np.zeros(0, np.int32)


class World:
    """Voxels and instances that change at random; every superpoint has one owner at most."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        self.count = self.frame = 0
        self.owned: dict[int, set[int]] = {}

    def delta(self) -> MapDelta:
        rng, known = self.rng, self.count
        self.frame += 1
        self.count += int(rng.integers(0, 4))
        ids = np.flatnonzero(rng.random(self.count) < 0.5).astype(np.int32)
        ids = np.union1d(ids, np.arange(known, self.count)).astype(np.int32)
        removed = np.flatnonzero(rng.random(self.count) < 0.2).astype(np.int32)
        return replace(
            EXAMPLE,
            full=False,
            frame_seq=self.frame,
            voxel_id=ids,
            voxel_coord=rng.integers(-9, 9, (len(ids), 3)).astype(np.int32),
            points_world=rng.random((len(ids), 3)).astype(np.float32),
            rgb=rng.integers(0, 255, (len(ids), 3)).astype(np.uint8),
            superpoint_id=rng.integers(-1, 6, len(ids)).astype(np.int32),
            removed_voxel_id=removed,
            instances=tuple(self.changed()),
            moved_from_id=NONE,
            moved_to_id=NONE,
        )

    def changed(self) -> list[Instance]:
        """Give some superpoints another owner and tell of everybody concerned."""
        before = {owner: set(owned) for owner, owned in self.owned.items()}
        for superpoint in self.rng.integers(0, 6, 2).tolist():
            for owned in self.owned.values():
                owned.discard(superpoint)
            self.owned.setdefault(int(self.rng.integers(1, 5)), set()).add(superpoint)
        concerned = [owner for owner in self.owned if self.owned[owner] != before.get(owner)]
        return [self.instance(owner) for owner in concerned]

    def instance(self, owner: int) -> Instance:
        owned = np.array(sorted(self.owned[owner]), np.int32)
        state = CONFIRMED if len(owned) else REMOVED
        return replace(EXAMPLE.instances[0], instance_id=owner, state=state, superpoint_id=owned)


def replica_of(deltas: list[MapDelta]) -> MapReplica:
    replica = MapReplica()
    for delta in deltas:
        replica.apply(delta)
    return replica


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), cut=st.integers(0, 8), full=st.integers(0, 12))
def test_one_delta_makes_the_same_replica_as_many(seed: int, cut: int, full: int) -> None:
    world = World(seed)
    deltas = [world.delta() for _ in range(8)]
    if full < len(deltas):
        deltas[full] = replace(deltas[full], full=True, removed_voxel_id=NONE)
    one_by_one = replica_of(deltas[:cut])
    late = replica_of([*deltas[:cut], merged(deltas[cut:])] if cut < 8 else deltas)
    for delta in deltas[cut:]:
        try:
            one_by_one.apply(delta)
        except ValueError:  # the whole in between forgot voxels that later ones remove
            return
    for one, other in zip(late.cloud(), one_by_one.cloud(), strict=True):
        assert np.array_equal(one, other)
    assert late.instances.keys() == one_by_one.instances.keys()
    assert (late.frame_seq, late.stamp_ns) == (one_by_one.frame_seq, one_by_one.stamp_ns)


def test_events_are_all_told() -> None:
    one = merged([EXAMPLE, replace(EXAMPLE, frame_seq=9)])
    assert one.events == EXAMPLE.events * 2
    assert one.frame_seq == 9
    assert len(one.voxel_id) == len(EXAMPLE.voxel_id)


def test_nothing_cannot_be_told() -> None:
    with pytest.raises(ValueError, match="no deltas"):
        merged([])
