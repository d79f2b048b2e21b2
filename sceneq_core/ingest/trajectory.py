"""How well an estimated trajectory fits the given one."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import RawFrame, Source
from sceneq_core.ingest.transforms import inverse, transform

Trajectory = Sequence[tuple[int, Float64]]
"""Pairs of ``seq`` and ``T_world_camera`` (4, 4)."""


@dataclass(frozen=True, slots=True)
class TrajectoryReport:
    """``rmse_m``: position error after alignment; ``length_m``: way along the given poses.

    ``frames``: poses that are in both trajectories.
    """

    rmse_m: float
    length_m: float
    frames: int


def trajectory_report(estimated: Trajectory, given: Trajectory) -> TrajectoryReport:
    """Compare the poses with equal ``seq``; raise ``ValueError`` when fewer than 3 are shared."""
    given_by_seq = dict(given)
    pairs = [(T, given_by_seq[seq]) for seq, T in estimated if seq in given_by_seq]
    if len(pairs) < 3:
        raise ValueError(f"only {len(pairs)} frames have both poses; at least 3 are needed")
    found, true = (_positions(poses) for poses in zip(*pairs, strict=True))
    steps = np.linalg.norm(np.diff(true, axis=0), axis=1)
    return TrajectoryReport(position_rmse_m(found, true), float(steps.sum()), len(pairs))


def corrected_trajectory(
    trajectory: Trajectory, keyframe_seq: Sequence[int], corrected: Mapping[int, Float64]
) -> list[tuple[int, Float64]]:
    """Return ``trajectory`` with the ``corrected`` poses of its keyframes.

    Between two keyframes the camera moves along with the earlier one. Frames are in order.
    """
    keyframes = set(keyframe_seq)
    T_new_old, result = np.eye(4), []
    for seq, T_world_camera in trajectory:
        if seq in keyframes:
            T_new_old = corrected.get(seq, T_world_camera) @ inverse(T_world_camera)
        result.append((seq, T_new_old @ T_world_camera))
    return result


def color_trajectory(source: Source) -> list[tuple[int, Float64]]:
    """Return the poses that ``source`` gives, moved to its colour camera as ingest does."""
    T_depth_color = inverse(source.T_color_depth)
    return [
        (raw.seq, raw.T_world_camera @ T_depth_color)
        for raw in source.frames()
        if isinstance(raw, RawFrame) and raw.T_world_camera is not None
    ]


def position_rmse_m(found: Float64, true: Float64) -> float:
    """Return the absolute trajectory error of positions (N, 3), both in metres.

    The root mean square distance after the best rigid alignment (Sturm et al. 2012,
    DOI 10.1109/IROS.2012.6385773).
    """
    error = transform(align(found, true), found) - true
    return float(np.sqrt((error**2).sum(axis=1).mean()))


def align(found: Float64, true: Float64) -> Float64:
    """Return the rigid T_true_found (4, 4) with the least squared distance of points (N, 3).

    Umeyama 1991, DOI 10.1109/34.88573, with scale 1 since depth is metric.
    """
    mean_found, mean_true = found.mean(axis=0), true.mean(axis=0)
    left, _, right = np.linalg.svd((true - mean_true).T @ (found - mean_found))
    # Without this sign the best orthogonal matrix may be a reflection.
    proper = np.diag([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    T_true_found = np.eye(4)
    T_true_found[:3, :3] = left @ proper @ right
    T_true_found[:3, 3] = mean_true - T_true_found[:3, :3] @ mean_found
    return T_true_found


def _positions(poses: Iterable[Float64]) -> Float64:
    return np.stack([T[:3, 3] for T in poses])
