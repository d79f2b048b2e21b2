"""A coverage kept up to date equals one that was filled at once."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.mapping.agreement import RegionViews
from sceneq_core.mapping.coverage import Coverage

REGIONS, SEGMENTS_A_VIEW = 4, 3
KEYFRAMES = st.lists(
    st.lists(
        st.tuples(
            st.integers(0, REGIONS - 1), st.integers(0, SEGMENTS_A_VIEW - 1), st.integers(1, 9)
        ),
        max_size=6,
    ),
    min_size=1,
    max_size=12,
)


def filled_at_once(keyframes, counted):
    """Return a coverage of as many keyframes with what was counted."""
    fresh = Coverage(top_views=3, min_pixels=2)
    for keyframe in range(keyframes):
        fresh.open_segments(SEGMENTS_A_VIEW, keyframe)
    for (region, segment), pixels in sorted(counted.items()):
        fresh.add(np.array([region]), np.array([segment], np.int32), np.array([pixels]))
    return fresh


def by_segment(views: RegionViews):
    """Return, for every region and segment number, what dominates the region in its keyframe."""
    return views.segment[:REGIONS][:, views.column]


def take_away(coverage, counted, draw):
    """Take some of what was counted away again."""
    gone = draw.draw(st.lists(st.sampled_from(sorted(counted)), unique=True)) if counted else []
    for region, segment in gone:
        pixels = counted.pop((region, segment))
        coverage.add(np.array([region]), np.array([segment], np.int32), np.array([-pixels]))


@given(KEYFRAMES, st.data())
def test_what_follows_from_the_pixels_is_kept_up_to_date(keyframes, draw):
    coverage, counted = Coverage(top_views=3, min_pixels=2), {}
    for keyframe, entries in enumerate(keyframes):
        owner = coverage.owners()
        before = by_segment(coverage.region_views(REGIONS)).copy()
        coverage.decide()
        first = coverage.open_segments(SEGMENTS_A_VIEW, keyframe)
        for region, label, pixels in entries:
            key = region, first + label
            counted[key] = counted.get(key, 0) + pixels
            coverage.add(np.array([region]), np.array([key[1]], np.int32), np.array([pixels]))
        take_away(coverage, counted, draw)
        fresh = filled_at_once(keyframe + 1, counted)
        views, expected = coverage.region_views(REGIONS), fresh.region_views(REGIONS)
        np.testing.assert_array_equal(coverage.owners(), fresh.owners())
        np.testing.assert_array_equal(by_segment(views), by_segment(expected))
        np.testing.assert_array_equal(views.top, expected.top)
        check_differing(coverage, counted, owner, before, by_segment(views))


def check_differing(coverage, counted, owner, before, now):
    """Check that the segments of changed views are marked, but for those that no region owned."""
    expected = {
        segment
        for region, segment in counted
        if segment < len(owner) and owner[segment] >= 0
        if before[region, segment] != now[region, segment]
    }
    marked = set(np.flatnonzero(coverage.differing()).tolist())
    owned = {segment for segment in marked if segment < len(owner) and owner[segment] >= 0}
    assert owned == expected
