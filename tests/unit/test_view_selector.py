"""Views of the ray-cast room, whose instances are known exactly."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.views.archive import ArchiveParams
from sceneq_core.views.choice import ChoiceParams
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_core.views.selector import ViewParams, ViewSelector
from sceneq_core.views.view import ViewSet

from support.room import Room
from support.true_map import TrueMap, delta, frame_of, instance

FRAMES = 7
RED_BALL = 4
ROOM = Room()


def observed(count: int = FRAMES, params: ViewParams | None = None) -> ViewSelector:
    selector, true_map = ViewSelector(params), TrueMap(ROOM)
    for i in range(count):
        frame, things = frame_of(ROOM, i, FRAMES)
        selector.observe(frame, true_map.integrate(frame, things))
    return selector


def by_id(selector: ViewSelector) -> dict[int, ViewSet]:
    return {view_set.instance_id: view_set for view_set in selector.view_sets()}


@pytest.fixture(scope="module")
def selector() -> ViewSelector:
    return observed()


def test_every_thing_has_views(selector):
    assert list(by_id(selector)) == list(range(1, 8))
    assert all(1 <= len(views.views) <= 5 for views in selector.view_sets())


def test_boxes_and_masks_are_where_the_thing_is(selector):
    views = by_id(selector)[RED_BALL].views
    assert len(views) >= 3
    for view in views:
        _, things = frame_of(ROOM, view.seq, FRAMES)
        rows, columns = np.nonzero(things == RED_BALL)
        truth = [columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]
        assert np.abs(view.box_xyxy - truth).max() <= 4
        assert abs(view.visible_px - len(rows)) < 0.15 * len(rows)
        x0, y0, x1, y1 = view.box_xyxy.astype(int)
        assert view.mask.shape == ((y1 - y0 + 1) // 2, (x1 - x0 + 1) // 2)
        assert view.visible_px == 4 * view.mask.sum()
        assert np.mean(things[y0:y1:2, x0:x1:2][view.mask] == RED_BALL) > 0.9


def test_images_are_those_of_the_frames(selector):
    view = by_id(selector)[RED_BALL].views[0]
    frame, _ = frame_of(ROOM, view.seq, FRAMES)
    rgb = rgb_from_jpeg(selector.image(view.seq))
    assert np.abs(rgb.astype(int) - frame.rgb).mean() < 4
    assert selector.image(999) is None


def test_view_params_reach_the_choice():
    selector = observed(3, ViewParams(choice=ChoiceParams(count=1)))
    assert all(len(view_set.views) == 1 for view_set in selector.view_sets())


def test_the_changes_add_up_to_the_view_sets():
    selector, true_map, told = ViewSelector(), TrueMap(ROOM), {}
    for i in range(FRAMES):
        frame, things = frame_of(ROOM, i, FRAMES)
        changed = selector.observe(frame, true_map.integrate(frame, things))
        told |= {view_set.instance_id: view_set for view_set in changed}
    assert told == by_id(selector)


def test_nothing_new_changes_nothing():
    selector = observed()
    assert selector.changes() == ()
    selector.follow(delta())
    assert selector.changes() == ()


def test_a_removed_instance_has_no_views_any_more():
    selector = observed()
    selector.follow(delta(instances=(instance(RED_BALL, [], state="removed"),)))
    assert selector.changes() == (ViewSet(RED_BALL, ()),)
    assert RED_BALL not in by_id(selector)


def test_a_merge_moves_the_views():
    selector = observed()
    before = by_id(selector)
    gone = instance(RED_BALL, [], state="removed", merged_into=3)
    whole = replace(instance(3, [3, RED_BALL]), centre_world=np.array([0.0, 1.0, 0.4]))
    selector.follow(delta(instances=(gone, whole)))
    changed = {view_set.instance_id: view_set for view_set in selector.changes()}
    assert changed[RED_BALL].views == ()
    old = {view.seq: view.visible_px for view in before[3].views}
    new = {view.seq: view.visible_px for view in changed[3].views}
    assert all(new[seq] > old[seq] for seq in old.keys() & new.keys())


def test_removed_voxels_are_not_seen_any_more():
    selector, true_map = ViewSelector(), TrueMap(ROOM)
    frame, things = frame_of(ROOM, 3, FRAMES)
    first = true_map.integrate(frame, things)
    selector.observe(frame, first)
    gone = first.voxel_id[first.superpoint_id == RED_BALL]
    selector.follow(delta(removed_voxel_id=gone))
    assert selector.changes() == (ViewSet(RED_BALL, ()),)


def test_a_whole_map_with_other_voxel_ids_keeps_the_views():
    selector, true_map = ViewSelector(), TrueMap(ROOM)
    for i in range(3):
        frame, things = frame_of(ROOM, i, FRAMES)
        selector.observe(frame, true_map.integrate(frame, things))
    before = by_id(selector)
    whole = true_map.snapshot()
    selector.follow(replace(whole, voxel_id=whole.voxel_id[::-1].copy()))
    assert selector.changes() == ()
    assert by_id(selector) == before


def test_an_empty_map_takes_all_views_away():
    selector = observed(3)
    ids = list(by_id(selector))
    selector.follow(delta(full=True))
    assert selector.changes() == tuple(ViewSet(i, ()) for i in ids)


def test_a_keyframe_seen_again_replaces_the_first():
    selector, true_map = observed(3), TrueMap(ROOM)
    frame, _ = frame_of(ROOM, 1, FRAMES)
    black = replace(frame, rgb=np.zeros_like(frame.rgb), stamp_ns=5)
    selector.see(black)
    selector.changes()
    assert rgb_from_jpeg(selector.image(1)).max() == 0
    assert {v.stamp_ns for s in selector.view_sets() for v in s.views if v.seq == 1} == {5}
    assert true_map.frame_seq == -1


def test_the_archive_stays_bounded_and_views_refer_only_to_what_is_there():
    selector = observed(FRAMES, ViewParams(archive=ArchiveParams(newest=1, capacity=3)))
    assert len(selector.archive) <= 3
    assert selector.archive.dropped_used + selector.archive.dropped_unused >= FRAMES - 3
    seqs = {view.seq for view_set in selector.view_sets() for view in view_set.views}
    assert all(selector.image(seq) is not None for seq in seqs)


def test_the_same_frames_give_the_same_views():
    a, b = observed(), observed()
    assert len(a.view_sets()) >= 3
    for left, right in zip(a.view_sets(), b.view_sets(), strict=True):
        for v, w in zip(left.views, right.views, strict=True):
            assert (v.seq, v.visible_px) == (w.seq, w.visible_px)
            assert np.array_equal(v.box_xyxy, w.box_xyxy)
            assert np.array_equal(v.mask, w.mask)
