"""What two robots see together makes one map, whoever of them is ahead, and whatever their clocks.

One saw a half of the room, the other the other half, long before by its own clock.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from sceneq_core.mapping.delta import CONFIRMED
from sceneq_core.mapping.mapper import Mapper, MapperParams
from sceneq_core.visits import seq_in_scene

from support.papered_room import PaperedRoom

ROOM = PaperedRoom()
COARSE = MapperParams(voxel_size_m=0.05)
ONE, OTHER = range(7, 18), range(11)
TURN_DEG = 15.0
HOUR_NS = 3600 * 10**9


@lru_cache
def seen(visit, numbers, began_ns=0):
    """Return keyframes of a visit with their segments, one a second."""
    views = [(i, *ROOM.seen(i, TURN_DEG * i, 0.1 * (i % 3), 0.2)) for i in numbers]
    return [
        (replace(frame, seq=seq_in_scene(visit, i), stamp_ns=began_ns + i * 10**9), labels)
        for i, frame, labels in views
    ]


def interleaved(rng):
    """Return the keyframes of both robots; the second has to see what is known to be placed."""
    one, other = list(seen(0, ONE, HOUR_NS)), list(seen(1, OTHER))
    order = [one.pop(0) for _ in range(rng.integers(1, len(one) + 1))]
    while one or other:
        order.append((one if not other or (one and rng.random() < 0.5) else other).pop(0))
    return order


def confirmed(keyframes):
    """Return the centres of what the map holds for sure, in a definite order."""
    mapper = Mapper(COARSE)
    for frame, labels in keyframes:
        assert not mapper.integrate(frame, labels).quarantined
    things = [one for one in mapper.snapshot().instances if one.state == CONFIRMED]
    return np.array(sorted(one.centre_world.tolist() for one in things))


@lru_cache
def alone():
    return confirmed(seen(0, range(18)))


@pytest.mark.parametrize("seed", range(4))
def test_one_map_comes_of_them_in_whatever_order_they_come(seed):
    centres = confirmed(interleaved(np.random.default_rng(seed)))
    assert centres.shape == alone().shape
    assert np.abs(centres - alone()).max() < COARSE.voxel_size_m


def test_what_only_the_one_sees_whose_clock_is_behind_is_confirmed():
    order = seen(0, ONE, HOUR_NS) + seen(1, OTHER)
    assert len(confirmed(order)) == len(alone()) > len(confirmed(seen(0, ONE)))


def test_what_is_gone_when_it_comes_is_gone_by_a_clock_that_is_behind():
    frame, labels = ROOM.seen(2, 30.0, 0.0, 0.0)
    emptied = replace(frame, depth_m=np.where(labels == 2, 3.0, frame.depth_m).astype(np.float32))
    mapper = Mapper(replace(COARSE, quarantine=replace(COARSE.quarantine, enabled=False)))
    for i in range(3):
        mapper.integrate(replace(frame, seq=i, stamp_ns=(i + 100) * 10**9), labels)
    before = sum(one.state == CONFIRMED for one in mapper.snapshot().instances)
    for i in range(8):
        later = replace(emptied, seq=seq_in_scene(1, i), stamp_ns=i * 10**9)
        mapper.integrate(later, np.where(labels == 2, 1, labels).astype(np.uint16))
    after = sum(one.state == CONFIRMED for one in mapper.snapshot().instances)
    assert (before, after) == (2, 1)
