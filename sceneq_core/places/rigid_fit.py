"""The rigid motion that most pairs of points agree on."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.ingest.transforms import transform


@dataclass(frozen=True, slots=True)
class FitParams:
    """Pairs agree up to ``reach_m`` plus ``reach_per_m`` of the distance from the camera.

    That is the error of a depth looked up beside an edge, not the noise of a sensor. ``tries``
    motions of three pairs each; the chance is drawn from ``seed``.
    """

    reach_m: float = 0.04
    reach_per_m: float = 0.015
    tries: int = 600
    seed: int = 7

    def __post_init__(self) -> None:
        need_positive(self, "reach_m")
        need_at_least(self, 0, "reach_per_m")
        need_at_least(self, 1, "tries")


@dataclass(frozen=True, slots=True)
class RigidFit:
    """``T_b_a`` (4, 4) and which pairs agree with it, bool (N,)."""

    T_b_a: Float64
    agrees: Bool


def fit_rigid(points_a: Float64, points_b: Float64, params: FitParams) -> RigidFit | None:
    """Return the motion of ``points_a`` (N, 3) onto ``points_b`` (N, 3), ``None`` below 3 pairs.

    Fischler and Bolles 1981, DOI 10.1145/358669.358692; Kabsch 1976, DOI
    10.1107/S0567739476001873. Same pairs, same bits.
    """
    count = len(points_a)
    if count < 3:
        return None
    rng = np.random.default_rng(params.seed)
    three = np.argsort(rng.random((params.tries, count)), axis=1)[:, :3]
    reach = params.reach_m + params.reach_per_m * np.linalg.norm(points_b, axis=1)
    tried = _kabsch(points_a[three], points_b[three])
    moved = np.einsum("tij,nj->tni", tried[:, :3, :3], points_a) + tried[:, None, :3, 3]
    support = (np.linalg.norm(moved - points_b, axis=2) < reach).sum(axis=1)
    T_b_a = tried[int(support.argmax())]
    for _ in range(3):
        agrees = _apart(T_b_a, points_a, points_b) < reach
        if agrees.sum() < 3:
            return None
        T_b_a = _kabsch(points_a[agrees][None], points_b[agrees][None])[0]
    return RigidFit(T_b_a, _apart(T_b_a, points_a, points_b) < reach)


def _apart(T_b_a: Float64, points_a: Float64, points_b: Float64) -> Float64:
    apart: Float64 = np.linalg.norm(transform(T_b_a, points_a) - points_b, axis=1)
    return apart


def _kabsch(a: Float64, b: Float64) -> Float64:
    """Return motions (T, 4, 4) that bring ``a`` (T, N, 3) nearest to ``b`` (T, N, 3)."""
    mean_a, mean_b = a.mean(axis=1, keepdims=True), b.mean(axis=1, keepdims=True)
    spread = np.einsum("tni,tnj->tij", b - mean_b, a - mean_a)
    left, _, right = np.linalg.svd(spread)
    left[:, :, 2] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[:, None]
    T_b_a = np.tile(np.eye(4), (len(a), 1, 1))
    T_b_a[:, :3, :3] = left @ right
    T_b_a[:, :3, 3] = mean_b[:, 0] - np.einsum("tij,tj->ti", left @ right, mean_a[:, 0])
    return T_b_a
