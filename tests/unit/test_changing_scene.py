"""A room in which things are moved, taken away and brought while a camera looks on."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sceneq_core.frame import Frame, depth_from_mm
from sceneq_core.mapping.mapper import Mapper
from sceneq_core.mapping.replica import MapReplica

from support.room import THINGS, Room, Thing
from support.surfaces import SMALL

HALF = 18
PASSES = 2 * HALF
MOVED = (-0.05, 1.15, 0.82)
BLUE_BOX, RED_BALL, NEW = "blue box", "red ball", "orange box"


def changed(things):
    """The blue box is put aside, the red ball is taken away, an orange box comes."""
    kept = [t for t in things if t.name != RED_BALL]
    moved = [replace(t, centre=MOVED) if t.name == BLUE_BOX else t for t in kept]
    return (*moved, Thing(NEW, (0.9, 0.0, 0.15), (240, 140, 20), size=(0.3, 0.3, 0.3)))


def person(i):
    """Walks past in the first pass at 1.5 m/s."""
    return Thing("person", (-1.5 + 0.15 * i, 0.1, 0.8), (60, 50, 110), size=(0.35, 0.3, 1.6))


def recording(step, *, walker=False):
    """Return every ``step``-th frame of two passes at 10 Hz with the true segments."""
    frames = []
    for i in range(0, PASSES, step):
        things = THINGS if i < HALF else changed(THINGS)
        if walker and 3 <= i < 15:
            things = (*things, person(i - 3))
        rgb, depth_mm, instance, pose = Room(things).frame(i % HALF, HALF)
        frame = Frame(i, i * 100_000_000, rgb, depth_from_mm(depth_mm), Room().K, pose)
        frames.append((frame, instance))
    return frames


class Told:
    """What a reader is told of a recording; names are those of the places things stand at."""

    def __init__(self, frames):
        self.mapper, self.replica, self.events, self.before = Mapper(SMALL), MapReplica(), [], {}
        for frame, label_image in frames:
            delta = self.mapper.integrate(frame, label_image)
            self.replica.apply(delta)
            self.events += delta.events
            if frame.seq < HALF:
                self.before = dict(self.replica.instances)

    @staticmethod
    def at(instances, centre):
        """Return the confirmed instance whose box is centred here, or ``None``."""
        gaps = {
            key: float(np.abs(one.aabb_world.mean(axis=0) - centre).max())
            for key, one in instances.items()
            if one.state == "confirmed"
        }
        best = min(gaps, key=gaps.get)
        return instances[best] if gaps[best] < 0.1 else None

    def kinds(self, instance_id):
        return [event.kind for event in self.events if event.instance_id == instance_id]


def centre(name):
    return np.array(next(t.centre for t in THINGS if t.name == name))


@cache
def told(step=1, *, walker=False):
    return Told(recording(step, walker=walker))


@pytest.mark.parametrize("step", [1, 2, 3])
def test_a_moved_thing_keeps_its_id_and_remembers_its_place(step):
    story = told(step)
    was = story.at(story.before, centre(BLUE_BOX))
    now = story.at(story.replica.instances, np.array(MOVED))
    assert was
    assert now
    assert now.instance_id == was.instance_id
    assert story.at(story.replica.instances, centre(BLUE_BOX)) is None
    assert story.kinds(now.instance_id)[-1] == "moved"
    (place,) = now.places
    assert np.abs(place.centre_world - was.centre_world).max() < 0.05
    assert place.from_ns <= place.until_ns <= now.state_since_ns
    merged = [e for e in story.events if e.kind == "merged" and e.other_id == now.instance_id]
    assert len(merged) == 1


@pytest.mark.parametrize("step", [1, 2, 3])
def test_a_vanished_thing_is_removed_and_leaves_no_ghost(step):
    story = told(step)
    was = story.at(story.before, centre(RED_BALL))
    assert was
    assert was.instance_id not in story.replica.instances
    assert story.kinds(was.instance_id)[-1] == "removed"
    points, _, _ = story.replica.cloud()
    apart = np.linalg.norm(points - centre(RED_BALL), axis=1)
    assert (apart < 0.1).sum() == 0


@pytest.mark.parametrize("step", [1, 2, 3])
def test_what_comes_is_new_and_what_stays_is_kept(step):
    story = told(step)
    new = story.at(story.replica.instances, np.array([0.9, 0.0, 0.15]))
    assert new
    assert new.instance_id not in story.before
    assert new.places == ()
    for name in ("green box", "yellow ball", "table"):
        was = story.at(story.before, centre(name))
        now = story.at(story.replica.instances, centre(name))
        assert was, name
        assert now, name
        assert was.instance_id == now.instance_id, name


@pytest.mark.parametrize("step", [2, 3])
def test_at_half_and_a_third_of_the_frame_rate_the_map_holds_the_same(step):
    whole, part = told(1), told(step)
    centres = [
        sorted(tuple(np.round(i.aabb_world.mean(axis=0), 1)) for i in t.replica.instances.values())
        for t in (whole, part)
    ]
    assert len(centres[0]) == len(centres[1])
    gaps = np.abs(np.array(centres[0])[:, None] - np.array(centres[1])[None]).max(axis=2)
    assert gaps.min(axis=1).max() < 0.25


def test_who_walks_past_leaves_nothing():
    story, still = told(2, walker=True), told(2)
    assert len(story.replica.instances) == len(still.replica.instances)
    points, _, _ = story.replica.cloud()
    on_the_way = (np.abs(points[:, 1] - 0.1) < 0.2) & (points[:, 2] > 0.5) & (points[:, 2] < 1.6)
    assert on_the_way.sum() == 0


def test_nothing_is_stale_or_removed_where_nothing_changes():
    frames = recording(2)[: HALF // 2]
    again = [(replace(f, seq=f.seq + HALF, stamp_ns=f.stamp_ns + 10**10), i) for f, i in frames]
    story = Told([*frames, *again])
    assert not {e.kind for e in story.events} & {"stale", "moved", "removed"}
