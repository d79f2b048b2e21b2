"""A view's box and mask agree with each other and lie inside what the keyframe shows."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from sceneq_core.views.keyframe import Keyframe
from sceneq_core.views.sighting import find_sightings, make_view

SHAPES = st.tuples(st.integers(1, 12), st.integers(1, 16))
LABELS = SHAPES.flatmap(lambda shape: hnp.arrays(np.int32, shape, elements=st.integers(0, 3)))


def keyframe_of(labels: np.ndarray) -> Keyframe:
    """Return a keyframe whose pixel k shows place k."""
    place = np.arange(labels.size, dtype=np.int32).reshape(labels.shape)
    height, width = labels.shape
    return Keyframe(
        3, 30, b"", (2 * height - 1, 2 * width), np.zeros(3), place, place[0], np.zeros(1, int)
    )


@given(LABELS)
def test_sightings_count_every_pixel(labels):
    sightings = find_sightings(keyframe_of(labels), np.append(labels.ravel(), np.int32(0)))
    assert sightings.visible_px.keys() == set(np.unique(labels).tolist()) - {0}
    assert sightings.cut == set(labels[0].tolist())
    for instance_id, visible_px in sightings.visible_px.items():
        assert visible_px == 4 * int((labels == instance_id).sum())


@given(LABELS, st.data())
def test_updated_sightings_equal_those_found_anew(labels, data):
    other = data.draw(hnp.arrays(np.int32, labels.shape, elements=st.integers(0, 4)))
    keyframe = keyframe_of(labels)
    before, now = (np.append(image.ravel(), np.int32(0)) for image in (labels, other))
    touched = np.flatnonzero(before != now).astype(np.int32)
    updated, anew = find_sightings(keyframe, before), find_sightings(keyframe, now)
    concerned = updated.update(keyframe, touched, before, now)
    assert concerned == (set(before[touched].tolist()) | set(now[touched].tolist())) - {0}
    assert (updated.visible_px, updated.cut) == (anew.visible_px, anew.cut)


@settings(max_examples=60)
@given(LABELS)
def test_the_mask_covers_the_box_and_takes_nothing_from_others(labels):
    keyframe = keyframe_of(labels)
    for instance_id in set(np.unique(labels).tolist()) - {0}:
        view = make_view(keyframe, labels, instance_id)
        x0, y0, x1, y1 = view.box_xyxy.astype(int).tolist()
        assert 0 <= x0 < x1 <= keyframe.size[1]
        assert 0 <= y0 < y1 <= keyframe.size[0]
        assert view.mask.shape == (-(-(y1 - y0) // 2), -(-(x1 - x0) // 2))
        assert all(view.mask[edge].any() for edge in (0, -1, np.s_[:, 0], np.s_[:, -1]))
        inside = labels[y0 // 2 : (y1 + 1) // 2, x0 // 2 : (x1 + 1) // 2][view.mask]
        assert set(np.unique(inside).tolist()) <= {0, instance_id}
        assert instance_id in inside
