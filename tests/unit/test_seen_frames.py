"""Keyframes that were looked at, over many visits and runs."""

from sceneq_core.visits import seq_in_scene
from sceneq_nodes import _seen_frames
from sceneq_nodes._seen_frames import SeenFrames


def test_each_visit_has_its_oldest_and_newest():
    seen = SeenFrames()
    assert (seen.oldest(5), seen.newest(5)) == (None, -1)
    second = seq_in_scene(1, 3)
    for seq in (2, 4, second):
        seen.add(seq, 10 * seq)
    assert (seen.oldest(0), seen.newest(0)) == (2, 4)
    assert (seen.oldest(second), seen.newest(second)) == (second, second)
    assert 4 in seen
    assert 3 not in seen
    assert (seen.stamp_of(4), seen.stamp_of(3)) == (40, None)


def test_what_is_different_is_known_until_it_is_kept(monkeypatch):
    monkeypatch.setattr(_seen_frames, "REMEMBERED", 2)
    seen = SeenFrames()
    seen.resume([(1, 10), (2, 20)])
    assert (seen.added, seen.removed) == ({}, set())
    seen.add(3, 30)
    assert (seen.added, seen.removed) == ({3: 30}, {1})
    assert list(seen.items()) == [(2, 20), (3, 30)]
    seen.settle()
    assert (seen.added, seen.removed) == ({}, set())


def test_in_another_map_nothing_was_looked_at():
    seen = SeenFrames()
    seen.resume([(1, 10)])
    seen.add(2, 20)
    seen.clear()
    assert (len(seen), seen.newest(1), seen.added, seen.removed) == (0, -1, {}, {1, 2})
    seen.add(2, 21)
    assert (seen.added, seen.removed) == ({2: 21}, {1})
