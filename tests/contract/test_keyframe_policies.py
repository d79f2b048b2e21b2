"""What every choice of keyframes promises."""

import numpy as np
import pytest

from sceneq_nodes._backends import build, kinds

KINDS = sorted(kinds("keyframes"))
FRAME_NS = 33_333_333


def pose(x_m: float) -> np.ndarray:
    T_world_camera = np.eye(4)
    T_world_camera[0, 3] = x_m
    return T_world_camera


def chosen(kind: str, way_m: list[float]) -> list[int]:
    policy = build("keyframes", {"kind": kind})
    taken = []
    for i, x_m in enumerate(way_m):
        if policy.is_due(pose(x_m), i * FRAME_NS):
            policy.took(pose(x_m), i * FRAME_NS)
            taken.append(i)
    return taken


@pytest.mark.parametrize("kind", KINDS)
def test_the_first_frame_is_taken_and_not_every_one_after_it(kind: str) -> None:
    taken = chosen(kind, [0.01 * i for i in range(100)])
    assert taken[0] == 0
    assert 2 <= len(taken) <= 50


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_way_gives_the_same_choice(kind: str) -> None:
    way_m = np.cumsum(np.random.default_rng(3).random(80) * 0.05).tolist()
    assert chosen(kind, way_m) == chosen(kind, way_m)


@pytest.mark.parametrize("kind", KINDS)
def test_a_due_frame_that_was_bad_is_followed_up_by_the_next(kind: str) -> None:
    policy = build("keyframes", {"kind": kind})
    assert policy.is_due(pose(0.0), 0)
    assert policy.is_due(pose(0.0), FRAME_NS)
    policy.took(pose(0.0), FRAME_NS)
    assert not policy.is_due(pose(0.0), 2 * FRAME_NS)
