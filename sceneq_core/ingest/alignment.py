"""How one depth image lies to another: point-to-plane ICP with projective association."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int32, Int64
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.ingest.depth_view import DepthView, Level
from sceneq_core.ingest.shading import likeness
from sceneq_core.ingest.transforms import nearest_rigid, rotation_of, transform

NEAREST_M = 0.05
"""Closer than any depth camera measures."""
STILL = 5e-5
"""A step of so many metres and radians is the last one."""


@dataclass(frozen=True, slots=True)
class AlignmentParams:
    """How images are aligned; lengths in metres.

    Points farther apart than ``reach_m`` on the finest level (twice that on each coarser one), or
    with normals that differ by more than ``max_angle_deg``, are not the same surface. ``noise_m``
    and ``noise_per_m`` (1/m, times the squared depth) are the deviation of a depth; beyond that a
    distance counts less and less. ``iterations`` on each level, from coarse to fine; the motion
    found may not leave the expected one by more than some ``prior_m`` where no surface says so.
    """

    reach_m: float = 0.05
    max_angle_deg: float = 35.0
    noise_m: float = 0.002
    noise_per_m: float = 0.003
    iterations: int = 8
    prior_m: float = 0.1

    def __post_init__(self) -> None:
        need_positive(self, "reach_m", "noise_m", "prior_m")
        need_at_least(self, 0, "noise_per_m")
        need_at_least(self, 1, "iterations")
        need_between(self, 0, 90, "max_angle_deg")


@dataclass(frozen=True, slots=True)
class Alignment:
    """Where ``source`` was found in the coordinates of ``target``.

    ``T_target_source`` (4, 4); ``overlap``: share of the source's points that fall on measured
    surface of the target; ``inliers``: share of those that lie on that surface; ``rmse_m`` of
    their distances to it; ``likeness``: correlation of the brightness of both there, NaN when
    there is no picture or it is too plain; ``information`` (6, 6) of rotation (rad) and
    translation (m) about the target's axes, from distances to planes divided by their noise.
    """

    T_target_source: Float64
    overlap: float
    inliers: float
    rmse_m: float
    likeness: float
    information: Float64

    @property
    def trust(self) -> float:
        """Return the share of surface that fits times how alike it looks, NaN without a picture.

        On hand-held and rendered images right alignments have 0.5 and more, false ones at most
        0.35: two walls fit two other ones, but do not look like them.
        """
        return self.inliers * self.likeness


def align_views(
    source: DepthView, target: DepthView, T_target_source: Float64, params: AlignmentParams
) -> Alignment:
    """Return the alignment found from the guess ``T_target_source`` (4, 4).

    Chen and Medioni 1992, DOI 10.1016/0262-8856(92)90066-C; projective association after
    Newcombe et al. 2011, DOI 10.1109/ISMAR.2011.6092378.
    """
    guess = T_target_source
    count = len(target.levels)
    for i, (fine, surface) in enumerate(zip(source.levels, target.levels, strict=True)):
        reach_m = params.reach_m * 2 ** (count - 1 - i)
        for _ in range(params.iterations):
            pairs = _pairs(fine, surface, guess, reach_m, params)
            step = _solve(pairs, params)
            guess = _moved(guess, step)
            if np.abs(step).max() < STILL:
                break
    return judge(source, target, nearest_rigid(guess), params)


def judge(
    source: DepthView, target: DepthView, T_target_source: Float64, params: AlignmentParams
) -> Alignment:
    """Return how well ``T_target_source`` (4, 4) fits, without changing it."""
    pairs = _pairs(source.levels[-1], target.levels[-1], T_target_source, params.reach_m, params)
    distance, near = pairs.distance_m, pairs.near
    count = max(int(near.sum()), 1)
    return Alignment(
        T_target_source,
        overlap=pairs.overlapping / max(source.count, 1),
        inliers=float(near.sum()) / max(pairs.overlapping, 1),
        rmse_m=float(np.sqrt((distance[near] ** 2).sum() / count)),
        likeness=_likeness(source, target, pairs),
        information=_normal_matrix(pairs)[0],
    )


@dataclass(frozen=True, slots=True)
class _Pairs:
    """Points with the planes they may lie on, and their rows in both levels: parallel rows.

    ``near``: close enough and turned alike; ``sigma_m`` the noise of the distance;
    ``overlapping``: how many points met surface at all, occluded ones left out.
    """

    source_row: Int64
    target_row: Int32
    points: Float64
    normals: Float64
    distance_m: Float64
    sigma_m: Float64
    near: Bool
    overlapping: int


def _pairs(
    source: Level, target: Level, T_target_source: Float64, reach_m: float, params: AlignmentParams
) -> _Pairs:
    points = transform(T_target_source, source.points)
    hit, row = _project(points, target)
    points = points.take(hit, axis=0)
    normals = source.normals.take(hit, axis=0) @ T_target_source[:3, :3].T
    surface, planes = target.points.take(row, axis=0), target.normals.take(row, axis=0)
    apart = points - surface
    distance = np.einsum("ij,ij->i", apart, planes)
    sigma = params.noise_m + params.noise_per_m * surface[:, 2] ** 2
    reach = reach_m + 3 * sigma
    alike = np.einsum("ij,ij->i", normals, planes) > np.cos(np.deg2rad(params.max_angle_deg))
    # On a slope the pixel's point may be far while its plane is near.
    close = np.einsum("ij,ij->i", apart, apart) < (2 * reach) ** 2
    near = alike & close & (np.abs(distance) < reach)
    # A point far behind the surface is hidden by it: that says nothing against the alignment.
    hidden = apart[:, 2] > reach
    overlapping = len(hit) - int(hidden.sum())
    return _Pairs(hit, row, points, planes, distance, sigma, near, overlapping)


def _project(points: Float64, target: Level) -> tuple[Int64, Int32]:
    """Return the points that fall on measured surface of ``target``, and its row there."""
    height, width = target.row.shape
    ahead = points[:, 2] > NEAREST_M
    z = np.where(ahead, points[:, 2], 1.0)
    column = np.rint(points[:, 0] / z * target.f[0] + target.c[0])
    line = np.rint(points[:, 1] / z * target.f[1] + target.c[1])
    inside = ahead & (column >= 0) & (column < width) & (line >= 0) & (line < height)
    hit = np.flatnonzero(inside)
    row = target.row[line[hit].astype(np.intp), column[hit].astype(np.intp)]
    measured = row >= 0
    return hit[measured], row[measured]


def _likeness(source: DepthView, target: DepthView, pairs: _Pairs) -> float:
    if not (len(source.shade) and len(target.shade)):
        return float("nan")
    near = pairs.near
    return likeness(source.shade[pairs.source_row[near]], target.shade[pairs.target_row[near]])


def _normal_matrix(pairs: _Pairs) -> tuple[Float64, Float64]:
    """Return the normal equations (6, 6) and (6,) of rotation and translation, unit variance."""
    near = pairs.near
    points, normals = pairs.points[near], pairs.normals[near]
    sigma, distance = pairs.sigma_m[near], pairs.distance_m[near]
    weight = 1.0 / (sigma * np.maximum(sigma, np.abs(distance)))  # Huber
    (x, y, z), (nx, ny, nz) = points.T, normals.T
    rows = np.stack((y * nz - z * ny, z * nx - x * nz, x * ny - y * nx, nx, ny, nz), axis=1)
    # Not a matrix product: that may round otherwise with another number of threads.
    weighted = rows * weight[:, None]
    matrix = np.einsum("ni,nj->ij", weighted, rows, optimize=False)
    return matrix, np.einsum("ni,n->i", weighted, distance, optimize=False)


def _solve(pairs: _Pairs, params: AlignmentParams) -> Float64:
    """Return the small motion (rotation, translation) that brings the points to their planes."""
    matrix, vector = _normal_matrix(pairs)
    prior = len(pairs.near) * 1e-4 / params.prior_m**2 + 1.0
    return np.linalg.solve(matrix + prior * np.eye(6), -vector).astype(np.float64)


def _moved(T_target_source: Float64, step: Float64) -> Float64:
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = rotation_of(step[:3]), step[3:]
    moved: Float64 = motion @ T_target_source
    return moved
