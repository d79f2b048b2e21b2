"""Odometry from depth images, and what it says when it does not know."""

import numpy as np
import pytest

from sceneq_core.ingest.alignment import AlignmentParams, align_views
from sceneq_core.ingest.depth_odometry import DepthOdometry, DepthOdometryParams
from sceneq_core.ingest.depth_view import DepthViewParams, depth_view, thin_depth
from sceneq_core.ingest.transforms import angle_deg, distance_m, inverse, rotation_of

from support.walk import ROOM, from_first, look, there_and_back

VIEW = DepthViewParams()


def view_of(shown):
    return depth_view(*thin_depth(shown.depth_mm, ROOM.K, VIEW), VIEW).shaded(shown.shading)


def track(looks, **params):
    odometry = DepthOdometry(DepthOdometryParams(**params))
    return [odometry.register(s.depth_mm, ROOM.K, i, s.shading) for i, s in enumerate(looks)]


def turned(yaw_deg):
    turn = np.eye(4)
    turn[:3, :3] = rotation_of(np.array([0.0, np.deg2rad(yaw_deg), 0.0]))
    return turn


def test_two_views_are_aligned_to_a_millimetre_or_two():
    one, other = look(3, 20), look(4, 20)
    found = align_views(view_of(other), view_of(one), np.eye(4), AlignmentParams())
    true = inverse(one.T_world_camera) @ other.T_world_camera
    assert distance_m(np.eye(4), true) > 0.1
    assert distance_m(found.T_target_source, true) < 0.003
    assert angle_deg(found.T_target_source, true) < 0.1
    assert found.overlap > 0.8
    assert found.inliers > 0.95
    assert found.likeness > 0.9
    assert found.rmse_m < 0.005


def test_a_walk_there_and_back_ends_where_it_began():
    looks = there_and_back(24)
    found = track(looks)
    apart = [distance_m(T, true) for T, true in zip(found, from_first(looks), strict=True)]
    assert max(apart) < 0.02


def test_a_wide_turn_is_found_by_looking_around():
    looks = [look(0, 5), look(2, 5)]
    aside = align_views(view_of(looks[1]), view_of(looks[0]), turned(-30), AlignmentParams())
    true = from_first(looks)[1]
    assert angle_deg(np.eye(4), true) > 25
    assert distance_m(aside.T_target_source, true) > 0.1
    assert distance_m(track(looks)[1], true) < 0.01


def test_a_cut_to_another_room_is_said_and_not_guessed():
    looks = [look(i, 24) for i in range(4)]
    mirrored = [
        type(s)(s.depth_mm[::-1, ::-1].copy(), lambda p, s=s: s.shading(-p), s.T_world_camera)
        for s in looks
    ]
    found = track([*looks, *mirrored, looks[-1]])
    assert [T is None for T in found] == [False] * 4 + [True] * 4 + [False]
    np.testing.assert_allclose(found[-1], found[3], atol=2e-3)


def test_without_a_picture_surfaces_are_believed_where_they_are_expected():
    looks = there_and_back(60)[:6]
    odometry = DepthOdometry(DepthOdometryParams())
    found = [odometry.register(s.depth_mm, ROOM.K, i) for i, s in enumerate(looks)]
    assert distance_m(found[-1], from_first(looks)[-1]) < 0.01


@pytest.mark.parametrize("field", ["reference_m", "min_trust", "search_best", "expected_deg"])
def test_parameters_have_limits(field):
    with pytest.raises(ValueError, match=field):
        DepthOdometryParams(**{field: 0})
