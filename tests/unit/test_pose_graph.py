"""Keyframes that recognise earlier ones pull a drifting walk together."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.ingest.pose_graph import PoseGraph, PoseGraphParams
from sceneq_core.ingest.transforms import angle_deg, distance_m, inverse

from support.walk import ROOM, drifting, from_first, there_and_back

LOOKS = there_and_back(7)
TRUE = from_first(LOOKS)
TURN, SHIFT = np.array([0.0, 0.004, 0.002]), np.array([0.006, 0.0, 0.004])
DRIFTING = drifting(LOOKS, TURN, SHIFT)


def walked(poses, looks=LOOKS, params=None):
    graph = PoseGraph(params or PoseGraphParams())
    told = {}
    online = []
    for seq, (pose, shown) in enumerate(zip(poses, looks, strict=True)):
        online.append(graph.add(10 * seq, pose, shown.depth_mm, ROOM.K, shown.shading))
        told |= graph.corrections()
    return graph, online, [told.get(10 * seq, T) for seq, T in enumerate(online)]


def worst_m(poses):
    return max(distance_m(T, true) for T, true in zip(poses, TRUE, strict=True))


def test_a_loop_with_drift_comes_together():
    graph, online, final = walked(DRIFTING)
    assert worst_m(DRIFTING) > 0.08
    assert worst_m(final) < 0.02
    assert distance_m(online[-1], TRUE[-1]) < 0.02
    assert angle_deg(final[-1], TRUE[-1]) < 0.5
    assert graph.closures >= 3
    assert graph.refused == 0


def test_a_closed_loop_corrects_the_keyframes_on_the_way():
    """Between two looks at one place the camera saw only what it could not recognise."""
    unlike = [
        replace(LOOKS[0], shading=lambda p, i=i: 9 * np.sin(p @ np.array([17 + i, 23 * i, 5])))
        for i in (1, 2, 3)
    ]
    step, error = np.eye(4), np.eye(4)
    step[0, 3], error[2, 3] = 0.5, 0.03
    true = [np.eye(4), step, step @ step, step, np.eye(4)]
    drifting = [T @ np.linalg.matrix_power(error, i) for i, T in enumerate(true)]
    graph, online, final = walked(drifting, [LOOKS[0], *unlike, LOOKS[0]])
    assert (len(graph), graph.closures) == (4, 0)
    assert graph.corrections() == {}
    np.testing.assert_allclose(online[:4], drifting[:4], atol=1e-12)
    assert distance_m(online[4], np.eye(4)) < 0.005
    off = [distance_m(a, b) for a, b in zip(final, true, strict=True)]
    assert off[0] == 0
    assert max(off) < 0.05 < distance_m(drifting[3], true[3])
    assert off[3] < off[2] < 0.045


def test_the_same_walk_gives_the_same_bits():
    one, other = walked(DRIFTING)[2], walked(DRIFTING)[2]
    assert [T.tobytes() for T in one] == [T.tobytes() for T in other]


def test_what_was_seen_before_is_no_new_node():
    graph, _, _ = walked(DRIFTING)
    assert len(graph) <= 4
    again, _, _ = walked(TRUE + TRUE, LOOKS + LOOKS)
    assert len(again) == len(graph)


def test_a_place_that_only_has_the_same_shape_is_refused():
    # The same surfaces in other colours: geometry alone would close this loop.
    alike = replace(LOOKS[0], shading=lambda points: -LOOKS[0].shading(points))
    graph, _, _ = walked([np.eye(4), np.eye(4)], [LOOKS[0], alike])
    assert (graph.closures, graph.refused, len(graph)) == (0, 1, 2)
    same, _, _ = walked([np.eye(4), np.eye(4)], [LOOKS[0], LOOKS[0]])
    assert (same.refused, len(same)) == (0, 1)


def test_a_loop_against_what_odometry_can_have_erred_is_refused():
    shifted = np.eye(4)
    shifted[0, 3] = 0.12
    graph, online, _ = walked([np.eye(4), shifted], [LOOKS[0], LOOKS[0]])
    assert graph.refused == 1
    np.testing.assert_array_equal(online[1], shifted)
    patient = PoseGraphParams(slack_m=0.3)
    graph, online, _ = walked([np.eye(4), shifted], [LOOKS[0], LOOKS[0]], patient)
    assert graph.refused == 0
    assert distance_m(online[1], np.eye(4)) < 0.005


def test_one_false_edge_among_right_ones_is_left_out():
    graph, _, _ = walked(TRUE[:7], LOOKS[:7], PoseGraphParams(same_overlap=0.97))
    (a, b), edge = next((k, e) for k, e in graph._edges.items() if e.measured and e.b - e.a > 1)
    wrong = edge.T_a_b.copy()
    wrong[:3, 3] += (0.0, 0.3, 0.3)
    graph._edges[(a, b)] = replace(edge, T_a_b=wrong)
    before = [node.T_world_camera for node in graph._nodes]
    graph._optimise()
    after = [node.T_world_camera for node in graph._nodes]
    assert max(distance_m(T, other) for T, other in zip(before, after, strict=True)) < 0.01


def test_between_keyframes_the_camera_moves_as_odometry_says():
    graph, online, _ = walked(DRIFTING)
    step = inverse(DRIFTING[-1]) @ DRIFTING[-2]
    np.testing.assert_allclose(graph.pose(DRIFTING[-2]), online[-1] @ step, atol=1e-9)


def test_there_is_no_news_without_a_loop():
    graph = PoseGraph(PoseGraphParams())
    graph.add(0, np.eye(4), LOOKS[0].depth_mm, ROOM.K)
    assert graph.corrections() == {}
    assert graph.corrections() == {}


@pytest.mark.parametrize(
    "field", ["min_overlap", "min_trust", "same_overlap", "slack_m", "news_m", "candidates"]
)
def test_parameters_have_limits(field):
    with pytest.raises(ValueError, match=field):
        PoseGraphParams(**{field: -1})
