"""Agreement of regions by equation 1, and the table of views behind it."""

import numpy as np
import pytest

from sceneq_core.mapping.agreement import expected_agreement
from sceneq_core.mapping.coverage import Coverage

from support.film import ids


def filled(*views, top_views=8, min_pixels=1):
    """Return a coverage from keyframes given as {(region, label): pixels}."""
    coverage = Coverage(top_views, min_pixels)
    for keyframe, view in enumerate(views):
        first = coverage.open_segments(max(label for _, label in view) + 1, keyframe)
        for (region, label), pixels in view.items():
            coverage.add(ids(region), ids(first + label), np.array([pixels]))
    return coverage


def test_agree_is_the_share_of_common_views_with_the_same_dominant_segment():
    views = filled(
        {(0, 1): 9, (1, 1): 5},
        {(0, 1): 9, (0, 2): 1, (1, 1): 2, (1, 2): 5},
        {(0, 3): 9, (1, 3): 5, (2, 3): 1},
        {(1, 1): 5, (2, 1): 2},
    ).region_views(3)
    agree = views.agree(ids(0, 0, 1, 1), ids(1, 2, 2, 1))
    assert agree == pytest.approx([2 / 3, 1.0, 1.0, 1.0])


def test_agree_is_zero_without_a_common_view():
    views = filled({(0, 1): 9}, {(1, 1): 9}).region_views(2)
    assert views.agree(ids(0, 0), ids(1, -1)).tolist() == [0.0, 0.0]


def test_only_the_most_visible_views_count():
    views = [{(0, 1): 9, (1, 1): 1}, {(0, 1): 5, (1, 2): 7}, {(0, 1): 8, (1, 2): 8}]
    assert filled(*views, top_views=3).region_views(2).agree(ids(0), ids(1)) == pytest.approx(1 / 3)
    assert filled(*views, top_views=2).region_views(2).agree(ids(0), ids(1)).tolist() == [0.0]
    assert filled(*views, top_views=1).region_views(2).agree(ids(0), ids(1)).tolist() == [0.0]


def test_a_view_with_few_pixels_is_none():
    views = filled({(0, 1): 9, (1, 1): 9}, {(0, 1): 9, (1, 2): 2}, min_pixels=3).region_views(2)
    same, common = views.compare(ids(0), ids(1))
    assert (same.tolist(), common.tolist()) == ([1], [1])


def test_what_is_taken_away_leaves_no_trace():
    coverage = filled({(0, 1): 9, (1, 1): 5})
    coverage.add(ids(0), ids(2), np.array([-9]))
    assert coverage.owners().tolist() == [-1, -1, 1]
    assert coverage.region_views(2).segment[0].tolist() == [0, 0]


def test_segments_are_owned_by_the_region_that_covers_most_of_them():
    owners = filled({(0, 1): 4, (1, 1): 6, (1, 2): 3, (0, 2): 3}).owners()
    assert owners[2:].tolist() == [1, 0]


def test_expected_agreement_is_shy_with_little_evidence():
    same, common = np.array([0, 0, 1, 9]), np.array([0, 1, 1, 9])
    assert expected_agreement(same, common) == pytest.approx([0.5, 0.25, 0.75, 0.95])
