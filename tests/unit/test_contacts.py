"""Which superpoints touch in a keyframe, and what adds up over the keyframes."""

import numpy as np
import pytest

from sceneq_core.mapping.contacts import contacts_in_view
from sceneq_core.mapping.neighbourhood import Neighbourhood
from sceneq_core.mapping.superpoints import SuperpointChange
from sceneq_core.mapping.surface import SurfacePoints
from sceneq_core.mapping.visibility import Visible
from sceneq_core.mapping.voxels import Voxels

from support.film import NO_CHANGE, NO_IDS, coloured, ids, touching

NONE_SEEN = np.zeros(0, np.int64)
UNGROUPED = ids(-1, -1, -1, -1)


def strip(points, normals, rgb=(90, 90, 90)):
    """Return the surface of one image row of points, two pixels apart."""
    count = len(points)
    return SurfacePoints(
        points_world=np.array(points, np.float64),
        normals_world=np.array(normals, np.float64),
        rgb=np.broadcast_to(np.array(rgb, np.uint8), (count, 3)),
        weight=np.ones(count),
        row=np.zeros(count, np.int32),
        column=np.arange(0, 2 * count, 2, dtype=np.int32),
    )


def contacts_of(surface, superpoint):
    voxels = Voxels(0.02)
    touched = voxels.integrate(surface)
    voxel_id = touched.voxel_id[touched.of_point]
    found = contacts_in_view(ids(*superpoint), voxel_id, surface, 2, voxels)
    columns = found.first, found.second, found.length, found.unbent
    return list(zip(*(column.tolist() for column in columns), strict=True))


def test_a_flat_border_is_unbent():
    flat = strip([(0.02 * i + 0.01, 0.01, 1.01) for i in range(4)], [(0, 0, -1)] * 4)
    assert contacts_of(flat, (5, 5, 2, 2)) == [(2, 5, 1, 1)]
    assert contacts_of(flat, (5, 5, -1, 2)) == []


def test_where_the_colour_changes_the_surface_does_not_go_on():
    points = [(0.02 * i + 0.01, 0.01, 1.01) for i in range(2)]
    picture = strip(points, [(0, 0, -1)] * 2, [(200, 200, 200), (40, 90, 160)])
    assert contacts_of(picture, (0, 1)) == [(0, 1, 1, 0)]
    shade = strip(points, [(0, 0, -1)] * 2, [(200, 200, 200), (180, 180, 180)])
    assert contacts_of(shade, (0, 1)) == [(0, 1, 1, 1)]


@pytest.mark.parametrize(("z_m", "unbent"), [(0.99, 0), (1.03, 1)])
def test_an_inner_corner_is_bent_and_an_outer_one_is_not(z_m, unbent):
    """A wall that comes towards the camera beside a floor, or falls away from it."""
    points = [(0.01, 0.01, 1.01), (0.03, 0.01, z_m)]
    normals = [(0, 0, -1), (-1, 0, 0)] if z_m < 1 else [(0, 0, -1), (1, 0, 0)]
    assert contacts_of(strip(points, normals), (0, 1)) == [(0, 1, 1, unbent)]


def test_what_is_one_behind_the_other_does_not_touch():
    points = [(0.01, 0.01, 1.01), (0.03, 0.01, 1.09)]
    assert contacts_of(strip(points, [(0, 0, -1)] * 2), (0, 1)) == []


def followed(*contacts, in_view=()):
    """Return a neighbourhood that saw these contacts, and then superpoints ``in_view``."""
    neighbourhood = Neighbourhood()
    for one in contacts:
        neighbourhood.follow(NO_CHANGE, Visible(NO_IDS, NO_IDS, NONE_SEEN, one), UNGROUPED)
    seen = Visible(ids(*in_view), ids(*in_view), np.ones(len(in_view), np.int64))
    neighbourhood.follow(NO_CHANGE, seen, UNGROUPED)
    return neighbourhood


def test_borders_add_up_over_superpoints_and_keyframes():
    neighbourhood = followed(
        touching((0, 2, 4, 4), (1, 3, 4, 0)), touching((1, 3, 2, 1), (2, 3, 9, 9))
    )
    borders = neighbourhood.borders(ids(7, 7, 8, 8))
    # Between 7 and 8: lengths 4 + 4 + 2, unbent 4 + 0 + 1. Inside 8 there is no border.
    assert borders.openness(ids(7, 8, 7), ids(8, 7, 9)).tolist() == [0.5, 0.5, 0.0]
    assert borders.meeting(ids(7)).tolist() == borders.meeting(ids(8)).tolist() == [7 << 32 | 8]
    assert borders.meeting(ids(9)).tolist() == []


def test_a_superpoint_borders_on_groups_by_shares_of_all_its_border():
    contacts = touching((0, 1, 5, 5), (0, 2, 3, 2), (0, 3, 2, 2))
    near = followed(contacts).borders(ids(-1, 4, 5, -1)).around(ids(2, 0))
    rows = zip(near.row.tolist(), near.group.tolist(), near.share.tolist(), strict=True)
    # Of the border of superpoint 0, ten long, 5 go on into group 4 and 2 into group 5.
    assert list(rows) == [(1, 4, 0.5), (1, 5, 0.2)]


def test_what_is_in_view_is_not_decided_by_its_border():
    near = followed(touching((0, 1, 5, 5)), in_view=(0,)).borders(ids(4, 4)).around(ids(0, 1))
    assert near.row.tolist() == [1]


def test_superpoints_that_end_have_no_contacts_any_more():
    neighbourhood = followed(touching((0, 1, 5, 5), (1, 2, 5, 5)))
    neighbourhood.follow(
        SuperpointChange(NO_IDS, NO_IDS, ids(0)), Visible(NO_IDS, NO_IDS, NONE_SEEN), UNGROUPED
    )
    borders = neighbourhood.borders(ids(3, 4, 5))
    assert borders.openness(ids(3, 4), ids(4, 5)).tolist() == [0.0, 1.0]


def test_what_borders_on_something_that_moved_is_disturbed_until_it_is_looked_at():
    neighbourhood = followed(touching((0, 1, 5, 5), (1, 2, 5, 5), (2, 3, 1, 1)), in_view=(0,))
    neighbourhood.move(ids(1, 3), ids(-1, -1), ids(0, 1))
    assert neighbourhood.disturbed().tolist() == [2]
    neighbourhood.calm()
    assert neighbourhood.disturbed().tolist() == []


def test_kinship_is_the_root_of_open_border_times_common_colours():
    neighbourhood = followed(touching((0, 1, 10, 4), (1, 2, 10, 0)))
    alike = coloured(s0=20, s1=20, s2=20)
    neighbourhood.follow(NO_CHANGE, Visible(NO_IDS, NO_IDS, NONE_SEEN, colours=alike), UNGROUPED)
    borders = neighbourhood.borders(ids(0, 1, 2, 3))
    found = borders.kinship(ids(0, 1, 0), ids(1, 2, 3))
    np.testing.assert_allclose(found, [np.sqrt(0.4), 0.0, 0.0])
    parts = borders.kinship_of_parts(ids(1), np.array([0]), ids(0), np.array([True]))
    np.testing.assert_allclose(parts, [np.sqrt(0.4)])
