"""Which frames become keyframes."""

import numpy as np
import pytest

from sceneq_core.ingest.keyframes import (
    EveryNth,
    EveryNthParams,
    KeyframePolicy,
    Motion,
    MotionParams,
)


def at(x: float, degrees: float = 0.0) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0, s, x], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]])


def chosen(policy: KeyframePolicy, poses: list[np.ndarray], bad: tuple[int, ...] = ()) -> list[int]:
    """Return the indices that are due and, unless their images are bad, taken."""
    due = []
    for index, T_world_camera in enumerate(poses):
        if policy.is_due(T_world_camera, index):
            due.append(index)
            if index not in bad:
                policy.took(T_world_camera, index)
    return due


def test_every_nth_starts_with_the_first() -> None:
    assert chosen(EveryNth(EveryNthParams(every=3)), [np.eye(4)] * 8) == [0, 3, 6]
    assert chosen(EveryNth(EveryNthParams()), [np.eye(4)] * 21) == [0, 10, 20]


def test_after_a_bad_keyframe_the_next_frame_stands_in() -> None:
    assert chosen(EveryNth(EveryNthParams(every=3)), [np.eye(4)] * 8, bad=(3,)) == [0, 3, 4, 7]
    motion = Motion(MotionParams())
    assert chosen(motion, [at(0), at(0.2), at(0.2), at(0.2)], bad=(1,)) == [0, 1, 2]


def test_motion_looks_at_the_way_since_the_last_keyframe() -> None:
    policy = Motion(MotionParams(translation_m=0.1, rotation_deg=90))
    assert chosen(policy, [at(0.04 * i) for i in range(8)]) == [0, 3, 6]


def test_motion_looks_at_the_angle() -> None:
    policy = Motion(MotionParams(translation_m=9, rotation_deg=10))
    assert chosen(policy, [at(0, 4.0 * i) for i in range(8)]) == [0, 3, 6]


def test_standing_still_gives_one_keyframe() -> None:
    assert chosen(Motion(MotionParams()), [at(1.0)] * 50) == [0]


@pytest.mark.parametrize(
    ("params", "values"),
    [
        (EveryNthParams, {"every": 0}),
        (MotionParams, {"translation_m": 0.0}),
        (MotionParams, {"rotation_deg": float("nan")}),
    ],
)
def test_parameters_name_what_is_wrong(params: type, values: dict) -> None:
    with pytest.raises(ValueError, match=next(iter(values))):
        params(**values)
