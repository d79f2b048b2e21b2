"""External masks: what they may be, and how superpoints take them."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from sceneq_core.mapping.mapper import Mapper
from sceneq_core.mapping.proposals import Proposals
from sceneq_core.mapping.proposed import ProposalParams, Proposed
from sceneq_core.mapping.replica import MapReplica

from support.room import THINGS
from support.surfaces import SMALL, room_frames

VIEWS = room_frames(5)
CLOUD = np.array([[0, 0, 1], [0.02, 0, 1], [0.5, 0, 1], [0.52, 0, 1]], np.float32)
NO_IDS = np.zeros(0, np.int32)


def proposals(pairs, score, points=CLOUD, label=()):
    mask_id, point_id = np.array(pairs, np.int32).reshape(-1, 2).T
    return Proposals(points, mask_id, point_id, np.array(score, np.float32), label)


def test_a_point_of_two_masks_belongs_to_the_better_one():
    masks = proposals([(0, 0), (0, 1), (1, 1), (1, 2)], [0.2, 0.9])
    assert masks.of_points().tolist() == [0, 1, 1, -1]


def test_among_equals_the_first_mask_wins():
    assert proposals([(1, 0), (0, 0)], [0.5, 0.5]).of_points().tolist() == [0, -1, -1, -1]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"points": CLOUD[:, :2]}, r"points_world: expected \(N, 3\), got \(4, 2\)"),
        ({"points": CLOUD * np.float32(np.nan)}, "points_world: not finite"),
        ({"pairs": [(2, 0)]}, "mask_id: expected 0 to 1, got 2 to 2"),
        ({"pairs": [(0, 4)]}, "point_id: expected 0 to 3, got 4 to 4"),
        ({"score": [0.1, np.inf]}, "score: expected one finite number for every mask"),
        ({"label": ("chair",)}, "label: expected 2 or none, got 1"),
    ],
)
def test_what_is_no_mask_is_refused(change, says):
    with pytest.raises(ValueError, match=f"^{says}$"):
        proposals(**{"pairs": [(0, 0)], "score": [1.0, 1.0]} | change)


def voted(proposed, points, superpoint, new=NO_IDS):
    voxel_id = np.arange(len(points), dtype=np.int32)
    superpoint = np.array(superpoint, np.int32)
    return proposed.vote(voxel_id, np.asarray(points, float), superpoint, new).tolist()


def test_superpoints_take_the_mask_of_most_of_their_voxels():
    proposed = Proposed(ProposalParams(reach_m=0.05))
    assert not proposed
    proposed.take(proposals([(0, 0), (0, 1), (1, 2)], [1.0, 1.0]))
    assert proposed
    points = [*CLOUD[:2], *CLOUD[2:], (3, 3, 3), CLOUD[0]]
    assert voted(proposed, points, [0, 0, 1, 2, 2, 2]) == [0, 1]
    assert proposed.of(np.arange(3)).tolist() == [0, 1, -1]
    assert voted(proposed, points, [0, 0, 1, 2, 2, 2]) == [], "nothing has changed since"


def test_a_number_given_again_votes_anew():
    proposed = Proposed(ProposalParams())
    proposed.take(proposals([(0, 0)], [1.0]))
    again = np.array([0], np.int32)
    assert voted(proposed, CLOUD[:1], [0]) == [0]
    assert voted(proposed, CLOUD[:1], [0], new=again) == [0]


@cache
def mapped_points():
    replica, mapper = MapReplica(), Mapper(SMALL)
    for view in VIEWS:
        replica.apply(mapper.integrate(*view))
    return replica.cloud()[0]


def masks_over(things):
    """Return one proposal for each group of things of the room, over what the map holds of them."""
    points = mapped_points()
    pairs = []
    for mask, names in enumerate(things):
        for name in names:
            pairs += [(mask, point) for point in np.flatnonzero(near(points, name))]
    return proposals(pairs, np.ones(len(things)), points)


def near(points, name):
    thing = next(t for t in THINGS if t.name == name)
    half = np.asarray(thing.size) / 2 if thing.size else np.full(3, thing.radius)
    return (np.abs(points - thing.centre) < half + 0.025).all(axis=1)


def instances_after(masks, views, trust=3):
    """``trust`` is how many views a mask counts as."""
    mapper = Mapper(replace(SMALL, proposed=ProposalParams(views=trust)))
    mapper.propose(masks)
    for view in views:
        mapper.integrate(*view)
    return mapper.snapshot()


def at(snapshot, name):
    """Return the ids of the instances that hold most of a thing."""
    replica = MapReplica()
    replica.apply(snapshot)
    points, _, instance_id = replica.cloud()
    ids, count = np.unique(instance_id[near(points, name)], return_counts=True)
    return {int(i) for i, n in zip(ids, count, strict=True) if i and n > 0.3 * count.sum()}


DIM = [(frame, np.where(labels > 2, 1, labels).astype(np.uint16)) for frame, labels in VIEWS]
"""Views in which all things are one segment."""


def test_masks_are_told_apart_where_no_segment_does():
    snapshot = instances_after(masks_over([["blue box"], ["green box"]]), DIM, trust=12)
    assert len(at(snapshot, "blue box")) == len(at(snapshot, "green box")) == 1
    assert at(snapshot, "blue box") != at(snapshot, "green box")


def test_segments_split_a_mask_over_two_things():
    masks = masks_over([["blue box", "green box"]])
    trusted = instances_after(masks, VIEWS, trust=12)
    assert at(trusted, "blue box") == at(trusted, "green box") != set()
    refined = instances_after(masks, VIEWS, trust=1)
    assert at(refined, "blue box").isdisjoint(at(refined, "green box"))


def test_segments_join_a_thing_of_two_masks():
    whole = instances_after(masks_over([["blue box"]]), VIEWS)
    points = mapped_points()
    box = np.flatnonzero(near(points, "blue box"))
    left = points[box, 0] < np.median(points[box, 0])
    halves = proposals(
        [(int(not side), point) for side, point in zip(left, box, strict=True)], [1.0, 1.0], points
    )
    assert (
        len(at(instances_after(halves, VIEWS, trust=1), "blue box"))
        == len(at(whole, "blue box"))
        == 1
    )


def test_things_without_a_mask_are_found_by_segments():
    snapshot = instances_after(masks_over([["blue box"]]), VIEWS)
    assert all(len(at(snapshot, name)) == 1 for name in ("blue box", "green box", "table"))


def test_masks_of_surface_that_nobody_sees_stay_pending():
    mapper = Mapper(SMALL)
    mapper.propose(masks_over([["blue box"]]))
    assert mapper.snapshot().instances == ()
    for view in VIEWS:
        mapper.integrate(*view)
    assert len(at(mapper.snapshot(), "blue box")) == 1
