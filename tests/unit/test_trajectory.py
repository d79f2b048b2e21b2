"""Alignment and error of trajectories."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sceneq_core.ingest.trajectory import (
    align,
    corrected_trajectory,
    position_rmse_m,
    trajectory_report,
)

RNG = np.random.default_rng(5)
POINTS = RNG.normal(size=(40, 3))


def moved(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    T_b_a = np.eye(4)
    T_b_a[:3, :3] = Rotation.from_rotvec([0.4, -2.0, 1.0]).as_matrix()
    T_b_a[:3, 3] = (4, -7, 2)
    return points @ T_b_a[:3, :3].T + T_b_a[:3, 3], T_b_a


def test_alignment_finds_the_motion() -> None:
    target, T_b_a = moved(POINTS)
    np.testing.assert_allclose(align(POINTS, target), T_b_a, atol=1e-12)


def test_alignment_never_mirrors() -> None:
    T_b_a = align(POINTS, POINTS * (1, 1, -1))
    assert np.linalg.det(T_b_a[:3, :3]) == pytest.approx(1.0)
    flat = POINTS * (1, 1, 0)
    assert np.linalg.det(align(flat, flat)[:3, :3]) == pytest.approx(1.0)


def test_error_counts_what_no_motion_explains() -> None:
    target, _ = moved(POINTS)
    assert position_rmse_m(POINTS, target) == pytest.approx(0.0, abs=1e-12)
    square = np.array([[1, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0.0]])
    lifted = square + (0, 0, 0.1) * np.array([[1], [-1], [1], [-1]])
    assert position_rmse_m(lifted, square) == pytest.approx(0.1)


def poses(positions: np.ndarray) -> list[tuple[int, np.ndarray]]:
    stack = np.tile(np.eye(4), (len(positions), 1, 1))
    stack[:, :3, 3] = positions
    return [(2 * i, T) for i, T in enumerate(stack)]


def test_report_compares_shared_frames_only() -> None:
    line = np.array([[0.1 * i, 0, 0.01 * i * i] for i in range(11)])
    report = trajectory_report(poses(line + 5)[2:], poses(line))
    assert report.frames == 9
    assert report.rmse_m == pytest.approx(0.0, abs=1e-12)
    steps = np.linalg.norm(np.diff(line[2:], axis=0), axis=1)
    assert report.length_m == pytest.approx(steps.sum())


def test_two_poses_cannot_be_aligned() -> None:
    line = poses(POINTS)
    with pytest.raises(ValueError, match="only 2 frames"):
        trajectory_report(line[:2], line)


def test_frames_move_along_with_the_keyframe_before_them() -> None:
    told = poses(np.arange(15.0).reshape(5, 3))
    shifted = told[2][1].copy()
    shifted[0, 3] += 7.0
    result = dict(corrected_trajectory(told, [0, 4, 8], {4: shifted}))
    moved_by = [result[seq][0, 3] - T[0, 3] for seq, T in told]
    assert moved_by == [0.0, 0.0, 7.0, 7.0, 0.0]
