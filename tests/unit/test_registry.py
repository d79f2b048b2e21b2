"""From groups of superpoints to instances: ids, states and events."""

import numpy as np
import pytest

from sceneq_core.mapping.association import GroupChange
from sceneq_core.mapping.doubt import DoubtParams
from sceneq_core.mapping.members import Members
from sceneq_core.mapping.presence import Look, Presence, PresenceParams
from sceneq_core.mapping.recognition import RecognitionParams
from sceneq_core.mapping.registry import Registry, RegistryParams
from sceneq_core.mapping.voxels import Voxels

from support.surfaces import patch, surface

UP = np.array([0.0, 0.0, 1.0])
STEP_NS = 100_000_000
NOTHING = np.zeros(0, np.int32)


class Lives:
    """A registry whose groups are patches of voxels; a keyframe every 0.1 s."""

    def __init__(self, **params):
        self.presence = Presence(PresenceParams())
        self.registry = Registry(RegistryParams(**params), self.presence)
        self.voxels = Voxels(0.1)
        self.of_group = {}
        self.hidden = NOTHING
        self.stamp_ns = 0
        self.events = []

    def grow(self, group, size):
        """Give a group ``size`` voxels of its own place, seen now."""
        x_m = (0.0, size / 10 - 0.01)
        points = patch(x_m, (group * 1.0, group * 1.0 + 0.05), 0.0, step_m=0.1)
        self.of_group[group] = self.voxels.integrate(surface(points)).voxel_id

    def members(self, group):
        voxel_id = self.of_group.get(group, NOTHING)
        points, rgb = self.voxels.means(voxel_id)
        return Members(np.arange(min(len(voxel_id), 1), dtype=np.int32), voxel_id, points, rgb)

    def look(self, **through):
        """Look at all groups and through the first ``n`` voxels of those named, once."""
        self.stamp_ns += STEP_NS
        missed = {int(name[1:]): count for name, count in through.items()}
        parts = [ids[missed.get(group, 0) :] for group, ids in self.of_group.items()]
        gone = [ids[: missed.get(group, 0)] for group, ids in self.of_group.items()]
        touched, through_id = np.concatenate([NOTHING, *parts]), np.concatenate([NOTHING, *gone])
        touched = np.setdiff1d(touched, self.hidden)
        self.voxels.misses[touched] = 0
        look = self.presence.look(self.voxels, touched, through_id, self.group_of, self.stamp_ns)
        result = self.registry.look(look, self.members)
        self.presence.clear(self.voxels, result.voxel_id)
        for group in result.group.tolist():
            self.of_group[group] = NOTHING
        for group, ids in self.of_group.items():
            self.of_group[group] = ids[~np.isin(ids, result.voxel_id)]
        return result

    def group_of(self, voxel_id):
        group = np.full(len(self.voxels), -1, np.int32)
        for number, ids in self.of_group.items():
            group[ids] = number
        return group[voxel_id]

    def show(self, *seen, founded=(), merged=(), **size):
        """A keyframe that shows groups, after a look at everything that there is."""
        for name, count in size.items():
            self.grow(int(name[1:]), count)
        self.look()
        return self.follow(*seen, founded=founded, merged=merged)

    def follow(self, *seen, founded=(), merged=()):
        groups = np.array(sorted({*seen, *(a for a, _ in merged)}), np.int32)
        change = GroupChange(groups, np.array(seen, np.int32), tuple(founded), tuple(merged))
        news, events = self.registry.update(change, self.members, self.stamp_ns, UP)
        self.events += [(event.kind, event.instance_id, event.other_id) for event in events]
        return [(i.instance_id, i.state, i.merged_into) for i in news]


def test_an_instance_needs_voxels_and_to_be_confirmed_views_and_time():
    lives = Lives(min_views=3, min_s=0.2, min_voxels=10)
    assert lives.show(0, 1, founded=[(0, -1), (1, -1)], g0=20, g1=5) == [(1, "tentative", 0)]
    assert lives.show(0, 1) == [(1, "tentative", 0)]
    assert lives.show(0) == [(1, "confirmed", 0)]
    assert lives.show(1, g1=10) == [(2, "confirmed", 0)]
    assert lives.events == [
        ("appeared", 1, 0), ("confirmed", 1, 0), ("appeared", 2, 0), ("confirmed", 2, 0),
    ]  # fmt: skip
    instance = lives.registry.instances[1]
    assert (instance.first_seen_ns, instance.last_seen_ns) == (STEP_NS, 3 * STEP_NS)
    assert (instance.state_since_ns, instance.voxel_count) == (3 * STEP_NS, 20)


def test_many_views_at_once_do_not_confirm():
    lives = Lives(min_views=2, min_s=0.5, min_voxels=10)
    lives.show(0, founded=[(0, -1)], g0=20)
    assert [lives.show(0)[0][1] for _ in range(5)] == ["tentative"] * 4 + ["confirmed"]


def test_an_instance_that_shrinks_to_nothing_ends_and_its_id_is_not_given_again():
    lives = Lives(min_views=1, min_s=0, min_voxels=10)
    lives.show(0, founded=[(0, -1)], g0=20)
    assert lives.show(0, g0=6) == [(1, "confirmed", 0)]
    assert lives.show(0, g0=0) == [(1, "removed", 0)]
    assert lives.show(0, founded=[(0, -1)], g0=20) == [(2, "confirmed", 0)]


def test_a_merge_keeps_the_older_id():
    lives = Lives(min_views=1, min_s=0, min_voxels=10)
    lives.show(0, 1, founded=[(0, -1), (1, -1)], g0=20, g1=30)
    assert lives.show(1, merged=[(0, 1)], g0=0, g1=50) == [(1, "confirmed", 0), (2, "removed", 1)]
    assert sorted(lives.registry.instances) == [1]
    assert lives.events[-1] == ("merged", 2, 1)


def test_a_merge_keeps_the_id_that_is_confirmed():
    lives = Lives(min_views=2, min_s=0, min_voxels=10)
    lives.show(0, founded=[(0, -1)], g0=20)
    lives.show(1, founded=[(1, -1)], g1=30)
    assert lives.show(1) == [(2, "confirmed", 0)]
    assert lives.show(1, merged=[(0, 1)], g0=0) == [(1, "removed", 2), (2, "confirmed", 0)]


def test_a_split_names_its_parent():
    lives = Lives(min_views=1, min_s=0, min_voxels=10)
    lives.show(0, founded=[(0, -1)], g0=20)
    lives.show(1, founded=[(1, 0)], g1=20)
    assert lives.registry.instances[2].parent == 1
    assert ("split", 2, 1) in lives.events


def test_what_is_looked_through_is_stale_then_removed_with_its_rest():
    lives = Lives(min_views=1, min_s=0, min_voxels=10)
    lives.show(0, founded=[(0, -1)], g0=20)
    for _ in range(3):
        lives.look(g0=14)
        assert lives.follow() == []
    gone = lives.look(g0=14)
    # 0.3 s after the first look through it: 14 are overdue; 6 were seen meanwhile and stay.
    assert (len(gone.voxel_id), gone.group.tolist()) == (14, [])
    assert lives.follow() == [(1, "stale", 0)]
    assert lives.events[-1] == ("stale", 1, 0)


def test_what_is_gone_takes_what_was_not_looked_at_with_it():
    lives = Lives(min_views=1, min_s=0, min_voxels=10)
    lives.show(0, founded=[(0, -1)], g0=20)
    lives.hidden = lives.of_group[0][14:]
    for _ in range(3):
        lives.look(g0=14)
        lives.follow()
    gone = lives.look(g0=14)
    assert (len(gone.voxel_id), gone.group.tolist()) == (20, [0])
    assert lives.follow() == [(1, "removed", 0)]
    assert [kind for kind, *_ in lives.events][-1] == "removed"
    assert lives.voxels.occupied(np.arange(20, dtype=np.int32)).tolist() == []


def test_a_stale_instance_that_is_seen_is_confirmed_again():
    lives = Lives(min_views=1, min_s=0, min_voxels=10)
    lives.show(0, founded=[(0, -1)], g0=40)
    for _ in range(4):
        lives.look(g0=14)
        lives.follow()
    assert lives.registry.instances[1].state == "stale"
    for _ in range(4):
        lives.look()
        lives.follow()
    assert lives.registry.instances[1].state == "confirmed"
    assert [kind for kind, *_ in lives.events][-2:] == ["stale", "seen_again"]


def test_a_tentative_instance_that_is_looked_through_is_never_confirmed():
    lives = Lives(min_views=2, min_s=0.2, min_voxels=10)
    lives.show(0, founded=[(0, -1)], g0=40)
    for _ in range(3):
        lives.look(g0=30)
        lives.follow(0)
    lives.look(g0=30)
    lives.follow()
    assert [kind for kind, *_ in lives.events] == ["appeared", "removed"]


@pytest.mark.parametrize(
    ("params", "field"),
    [
        (RegistryParams, "min_views"),
        (RegistryParams, "min_voxels"),
        (DoubtParams, "min_share"),
        (DoubtParams, "min_views"),
        (RecognitionParams, "min_likeness"),
        (RecognitionParams, "max_rival"),
        (PresenceParams, "min_views"),
        (PresenceParams, "hold"),
    ],
)
def test_a_bad_parameter_is_named(params, field):
    with pytest.raises(ValueError, match=f"^{field}: "):
        params(**{field: 0})


def test_a_look_counts_per_group():
    voxels, presence = Voxels(0.1), Presence(PresenceParams(min_views=2, min_s=0.1))
    ids = voxels.integrate(surface(patch((0.0, 0.79), (0.0, 0.05), 0.0, step_m=0.1))).voxel_id
    group = np.array([0, 0, 0, 1, 1, 1, -1, -1])
    looks = [
        presence.look(voxels, ids[:4], ids[4:], lambda i: group[i], stamp) for stamp in (0, STEP_NS)
    ]
    assert isinstance(looks[0], Look)
    assert looks[1].group.tolist() == [0, 1]
    assert (looks[1].seen.tolist(), looks[1].through.tolist()) == ([3, 1], [0, 2])
    assert [look.gone_id.tolist() for look in looks] == [[], ids[4:].tolist()]
    assert looks[1].lost.tolist() == [0, 2]
