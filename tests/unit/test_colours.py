"""The colours of superpoints, and what groups of them have in common."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.mapping.colours import Colours, Palette, colours_in_view

from support.film import ids

CHANNEL = st.integers(0, 255)
RGB = st.tuples(CHANNEL, CHANNEL, CHANNEL)


def palette_of(*rgb, voxels=10):
    """Return the palette of superpoints 0, 1, ... with these colours, all of one size."""
    superpoint = np.repeat(np.arange(len(rgb), dtype=np.int32), voxels)
    palette = Palette()
    palette.see(colours_in_view(superpoint, np.repeat(np.array(rgb, np.uint8), voxels, axis=0)))
    return palette


def test_the_colour_of_a_superpoint_is_the_mean_of_its_voxels():
    superpoint = ids(4, 4, 2, -1)
    rgb = np.array([[255, 255, 255], [0, 0, 0], [255, 255, 255], [9, 9, 9]], np.uint8)
    seen = colours_in_view(superpoint, rgb)
    assert seen.superpoint_id.tolist() == [2, 4]
    assert seen.voxels.tolist() == [1, 2]
    # Half of the lightness: 100 of white, 53 of the middle grey.
    np.testing.assert_allclose(seen.lab, [[50, 0, 0], [26.7, 0, 0]], atol=0.1)


def test_nothing_in_view_has_no_colours():
    seen = colours_in_view(ids(), np.zeros((0, 3), np.uint8))
    assert seen.lab.shape == (0, 3)
    Palette().see(seen)


def test_groups_share_the_colours_that_both_have():
    red, blue, green = (200, 30, 30), (30, 30, 200), (30, 200, 30)
    palette = palette_of(red, blue, red, green)
    # Groups 0 = red and blue, 1 = red, 2 = green; 3 has no superpoint.
    common = palette.common(ids(0, 0, 1, 2), ids(0, 0, 1, 1), ids(0, 1, 2, 3))
    np.testing.assert_allclose(common, [1.0, 0.5, 0.0, 0.0], atol=1e-6)


def test_the_keyframe_that_shows_most_of_a_superpoint_says_its_colour():
    dark, light = np.array([[10.0, 0, 0]], np.float32), np.array([[45.0, 0, 0]], np.float32)
    palette = Palette()
    palette.see(Colours(ids(0), dark, np.array([20])))
    palette.see(Colours(ids(0), light, np.array([5])))
    palette.see(Colours(ids(1), dark, np.array([5])))
    assert palette.common(ids(0, 1), ids(0), ids(1)) == pytest.approx(1.0)
    palette.forget(ids(0, 7))
    assert palette.common(ids(0, 1), ids(0), ids(1)) == 0.0


@given(st.lists(RGB, min_size=2, max_size=6), st.data())
def test_common_colour_is_a_share_and_symmetric(rgb, data):
    palette = palette_of(*rgb)
    group = ids(*data.draw(st.lists(st.integers(-1, 2), min_size=len(rgb), max_size=len(rgb))))
    there, back = (
        palette.common(group, ids(*a), ids(*b)) for a, b in (((0, 1), (1, 2)), ((1, 2), (0, 1)))
    )
    np.testing.assert_allclose(there, back)
    assert (there >= 0).all()
    assert (there <= 1 + 1e-6).all()


@given(RGB, st.integers(-6, 6))
def test_a_little_more_light_is_nearly_the_same_colour(rgb, more):
    lighter = tuple(int(np.clip(channel + more, 0, 255)) for channel in rgb)
    common = palette_of(rgb, lighter).common(ids(0, 1), ids(0), ids(1))
    assert common[0] > 0.2
