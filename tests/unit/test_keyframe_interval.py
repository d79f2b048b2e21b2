"""Keyframes by capture time: the frame rate of the camera does not matter."""

import numpy as np
import pytest

from sceneq_core.ingest.keyframes import Interval, IntervalParams

POSE = np.eye(4)


def taken(stamps_ns: list[int], period_s: float = 0.3) -> list[int]:
    policy, result = Interval(IntervalParams(period_s)), []
    for i, stamp_ns in enumerate(stamps_ns):
        if policy.is_due(POSE, stamp_ns):
            policy.took(POSE, stamp_ns)
            result.append(i)
    return result


def test_three_seconds_hold_ten_keyframes_at_every_frame_rate() -> None:
    for rate_hz in (10, 30, 60):
        stamps_ns = [i * 1_000_000_000 // rate_hz for i in range(3 * rate_hz)]
        assert taken(stamps_ns) == list(range(0, 3 * rate_hz, 3 * rate_hz // 10))


@pytest.mark.parametrize("rate_hz", [4, 5, 7, 10, 12, 15, 24, 25, 30, 60])
def test_a_rate_that_does_not_fit_the_period_gives_as_many(rate_hz: int) -> None:
    stamps_ns = [i * 1_000_000_000 // rate_hz for i in range(30 * rate_hz)]
    chosen = taken(stamps_ns)
    assert abs(len(chosen) - 100) <= 1
    due_ns = [n * 300_000_000 for n in range(len(chosen))]
    off_ns = np.abs(np.array(stamps_ns)[chosen] - due_ns)
    assert off_ns.max() <= 500_000_000 / rate_hz + 2


def test_after_a_pause_the_first_frame_is_taken_and_the_beat_starts_anew() -> None:
    stamps_ns = [n * 100_000_000 for n in (0, 1, 2, 3, 20, 21, 22, 23)]
    assert taken(stamps_ns) == [0, 3, 4, 7]


def test_a_slow_camera_gives_every_frame() -> None:
    assert taken([0, 500_000_000, 1_000_000_000]) == [0, 1, 2]


def test_jitter_of_the_timer_does_not_skip_a_frame() -> None:
    assert taken([0, 299_500_000, 600_100_000]) == [0, 1, 2]


def test_a_clock_that_was_set_back_starts_anew() -> None:
    assert taken([5_000_000_000, 5_100_000_000, 1_000_000_000, 1_100_000_000]) == [0, 2]


def test_a_period_of_nothing_is_refused() -> None:
    with pytest.raises(ValueError, match="period_s"):
        IntervalParams(0.0)
