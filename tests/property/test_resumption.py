"""A map that is taken apart and built again at any moment becomes the same map, bit by bit."""

import itertools
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.mapping.correction import Correction
from sceneq_core.mapping.digest import map_digest
from sceneq_core.mapping.mapper import Mapper
from sceneq_core.mapping.proposals import Proposals
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.mapping.resumption import resumed, state_of
from sceneq_core.state import StateError, take_apart

from support.room import Room
from support.surfaces import SMALL, room_frames

VIEWS = room_frames(7, Room(size=(120, 90), focal_px=97.5))
CORRECTED_AFTER, PROPOSED_AFTER = 4, 1


def step(mapper, number):
    """Give a mapper its keyframe and, at times, what else enters a map."""
    delta = mapper.integrate(*VIEWS[number])
    if number == PROPOSED_AFTER:
        points = delta.points_world[:200]
        mask, point = np.zeros(100, np.int32), np.arange(100, dtype=np.int32)
        mapper.propose(Proposals(points, mask, point, np.ones(1, np.float32)))
    if number == CORRECTED_AFTER:
        pose = VIEWS[1][0].T_world_camera.copy()
        pose[0, 3] += 0.03
        delta = mapper.correct(Correction(np.array([1]), pose[None]))
    return delta


def told(delta):
    """Everything a delta says, comparable."""
    said = [take_apart(getattr(delta, field.name)) for field in fields(delta)]
    return [(state.parts, [array.tobytes() for array in state.arrays]) for state in said]


def digest(mapper):
    replica, delta = MapReplica(), mapper.snapshot()
    replica.apply(delta)
    points, _, instance_id = replica.cloud()
    coord = np.floor(points / delta.voxel_size_m).astype(np.int32)
    return map_digest(coord, points, instance_id)


@pytest.fixture(scope="module")
def undisturbed():
    mapper = Mapper(SMALL)
    return [told(step(mapper, number)) for number in range(len(VIEWS))], digest(mapper)


@settings(max_examples=5, deadline=None)
@given(stops=st.sets(st.integers(0, len(VIEWS) - 1)))
def test_a_map_resumed_at_any_moments_is_the_undisturbed_one(undisturbed, stops):
    mapper, deltas = Mapper(SMALL), []
    for number in range(len(VIEWS)):
        deltas.append(told(step(mapper, number)))
        if number in stops:
            mapper, beside = resumed(state_of(mapper, {"number": number}), SMALL)
            assert beside == {"number": number}
    assert (deltas, digest(mapper)) == undisturbed


def test_a_state_shares_no_memory_with_the_map():
    mapper = Mapper(SMALL)
    step(mapper, 0)
    state = state_of(mapper, {})
    before = [array.tobytes() for array in state.arrays]
    step(mapper, 1)
    assert [array.tobytes() for array in state.arrays] == before


def test_no_two_arrays_of_a_map_overlap():
    """Else one would change with the other in a map, but not in the map built from its state."""
    mapper = Mapper(SMALL)
    for number in range(len(VIEWS)):
        step(mapper, number)
    spans = sorted(np.lib.array_utils.byte_bounds(array) for array in arrays_in(mapper))
    assert len(spans) > 100
    assert all(one[1] <= other[0] for one, other in itertools.pairwise(spans))


def test_what_a_state_was_taken_with_must_be_what_it_is_resumed_with():
    mapper = Mapper(SMALL)
    with pytest.raises(StateError, match="other parameters"):
        resumed(state_of(mapper, {}), replace(SMALL, voxel_size_m=0.03))
    with pytest.raises(StateError, match="no mapper but a dict"):
        resumed(take_apart({}), SMALL)


def test_a_state_of_another_version_is_refused():
    state = state_of(Mapper(SMALL), {})
    part = next(p for p in state.parts if p[:2] == ["object", "sceneq_core.mapping.voxels:Voxels"])
    part[part.index("_count")] = "_number"
    with pytest.raises(StateError, match="voxels:Voxels differs in _count, _number"):
        resumed(state, SMALL)


def arrays_in(root):
    """Return every array with content in an object graph, once."""
    found, seen, waiting = [], set(), [root]
    while waiting:
        value = waiting.pop()
        if id(value) in seen:
            continue
        seen.add(id(value))
        if isinstance(value, np.ndarray):
            found += [value] if value.nbytes else []
        elif isinstance(value, dict):
            waiting += [*value.keys(), *value.values()]
        elif isinstance(value, (list, tuple, set)):
            waiting += value
        elif type(value).__module__.startswith("sceneq_core"):
            slots = [s for c in type(value).__mro__ for s in getattr(c, "__slots__", ())]
            waiting += [getattr(value, name) for name in slots if hasattr(value, name)]
            waiting += getattr(value, "__dict__", {}).values()
    return found
