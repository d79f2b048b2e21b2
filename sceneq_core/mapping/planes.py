"""Large planes among small flat pieces of surface: level ones and upright ones."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_core.mapping.boxes import level_axes

_HEIGHT_STEP_M = 0.02
_OFFSET_STEP_M = 0.05
_AZIMUTHS = 360
_VOTE_DEG = 10
"""A piece votes for the azimuths this close to its own: the normals of small pieces are noisy."""
_FIT_M = (0.08, 0.05, 0.04)
"""How far a piece may be from the plane that is fitted through it, in three rounds."""
_MIN_PIECES = 8
_MIN_SHARE = 0.1
_MAX_UPRIGHT = 60


@dataclass(frozen=True, slots=True)
class Pieces:
    """Flat pieces of surface: ``centre_world`` and unit ``normal_world`` float64 (N, 3), area."""

    centre_world: Float64
    normal_world: Float64
    area_m2: Float64

    def take(self, rows: Bool | Int64) -> "Pieces":
        """Return some of the pieces."""
        return Pieces(self.centre_world[rows], self.normal_world[rows], self.area_m2[rows])


@dataclass(frozen=True, slots=True)
class Plane:
    """Points p with ``normal_world`` @ p = ``offset_m``; the normal points to the visible side."""

    normal_world: Float64
    offset_m: float

    def height_m(self, points_world: Float64) -> Float64:
        """Return the signed distances (N,) of points (N, 3), positive on the visible side."""
        heights: Float64 = points_world @ self.normal_world - self.offset_m
        return heights


def level_planes(
    pieces: Pieces, up_world: Float64, lean_deg: float, min_area_m2: float
) -> tuple[Plane, ...]:
    """Return the large level planes whose visible side is ``up_world``, from the lowest upwards.

    With the opposite direction for ``up_world`` they are seen from below, the highest first. What
    is much smaller than the largest does not count: below a floor that mirrors lies a little noise.
    """
    facing = pieces.take(pieces.normal_world @ up_world > np.cos(np.deg2rad(lean_deg)))
    if not len(facing.area_m2):
        return ()
    height = facing.centre_world @ up_world
    lowest = float(height.min())
    place = ((height - lowest) / _HEIGHT_STEP_M).astype(np.int64)
    area = np.convolve(np.bincount(place, facing.area_m2), np.ones(5), "same")
    peaks = _peaks(area, max(min_area_m2, _MIN_SHARE * float(area.max())))
    middles = lowest + (peaks + 0.5) * _HEIGHT_STEP_M
    fitted = (_fitted(facing, Plane(up_world, float(middle))) for middle in middles)
    return tuple(plane for plane in fitted if plane is not None)


def upright_planes(
    pieces: Pieces, up_world: Float64, lean_deg: float, min_area_m2: float
) -> tuple[tuple[Plane, float], ...]:
    """Return the large upright planes with their area in square metres, about the largest first.

    Azimuth and distance from the middle are voted for by area (P. V. C. Hough, US 3 069 654, 1962);
    the pieces on a plane are taken out before the next one is looked for.
    """
    level = level_axes(up_world)[:, :2]
    leaning = np.abs(pieces.normal_world @ up_world) < np.sin(np.deg2rad(lean_deg))
    rest = pieces.take(leaning)
    found: list[tuple[Plane, float]] = []
    for _ in range(_MAX_UPRIGHT):
        guess, votes_m2 = _most_voted(rest, level)
        if guess is None or votes_m2 < 0.5 * min_area_m2:
            break
        plane = _fitted(_facing(rest, guess, lean_deg), guess) or guess
        on = _lies_on(rest, plane, lean_deg) | _lies_on(rest, guess, lean_deg)
        area_m2 = float(rest.area_m2[_lies_on(rest, plane, lean_deg)].sum())
        if area_m2 >= min_area_m2:
            found.append((plane, area_m2))
        if not on.any():
            break
        rest = rest.take(~on)
    return tuple(found)


def _peaks(area: Float64, least: float) -> Int64:
    """Return the places of the local maxima that are at least ``least``, in order."""
    padded = np.pad(area, 2)
    around = np.stack([padded[shift : shift + len(area)] for shift in range(5)])
    # Of equal neighbours the first one is the peak.
    is_peak = (area >= around.max(axis=0)) & (area > around[:2].max(axis=0)) & (area >= least)
    return np.flatnonzero(is_peak)


def _most_voted(pieces: Pieces, level: Float64) -> tuple[Plane | None, float]:
    if len(pieces.area_m2) < _MIN_PIECES:
        return None, 0.0
    middle = pieces.centre_world.mean(axis=0)
    position = (pieces.centre_world - middle) @ level
    facing = pieces.normal_world @ level
    azimuth_deg = np.rint(np.rad2deg(np.arctan2(facing[:, 1], facing[:, 0]))).astype(np.int64)
    azimuth = (azimuth_deg[:, None] + np.arange(-_VOTE_DEG, _VOTE_DEG + 1)) % _AZIMUTHS
    angle = np.deg2rad(azimuth)
    distance = position[:, :1] * np.cos(angle) + position[:, 1:] * np.sin(angle)
    reach = float(np.sqrt((position**2).sum(axis=1)).max()) + _OFFSET_STEP_M
    places = int(2 * reach / _OFFSET_STEP_M) + 2
    place = azimuth * places + ((distance + reach) / _OFFSET_STEP_M).astype(np.int64)
    weight = np.repeat(pieces.area_m2, azimuth.shape[1])
    votes = np.bincount(place.ravel(), weight, _AZIMUTHS * places)
    best_azimuth, best_place = divmod(int(votes.argmax()), places)
    angle_best = np.deg2rad(best_azimuth)
    normal = level @ np.array([np.cos(angle_best), np.sin(angle_best)])
    offset = (best_place + 0.5) * _OFFSET_STEP_M - reach + float(normal @ middle)
    return Plane(normal, offset), float(votes.max())


def _facing(pieces: Pieces, plane: Plane, lean_deg: float) -> Pieces:
    return pieces.take(pieces.normal_world @ plane.normal_world > np.cos(np.deg2rad(lean_deg)))


def _lies_on(pieces: Pieces, plane: Plane, lean_deg: float) -> Bool:
    close = np.abs(plane.height_m(pieces.centre_world)) < _FIT_M[0]
    facing = pieces.normal_world @ plane.normal_world > np.cos(np.deg2rad(lean_deg))
    return np.asarray(close & facing)


def _fitted(pieces: Pieces, guess: Plane) -> Plane | None:
    """Return the least-squares plane through the pieces close to a guess, ``None`` = too few.

    Positions tell the direction of a large plane a hundred times better than normals do.
    """
    plane = guess
    for reach_m in _FIT_M:
        near = pieces.take(np.abs(plane.height_m(pieces.centre_world)) < reach_m)
        if len(near.area_m2) < _MIN_PIECES:
            return None
        weight = near.area_m2 / near.area_m2.sum()
        middle = weight @ near.centre_world
        around = near.centre_world - middle
        spread = (around * weight[:, None]).T @ around
        normal = np.linalg.eigh(spread)[1][:, 0]
        normal = normal if normal @ guess.normal_world > 0 else -normal
        plane = Plane(normal, float(normal @ middle))
    # Few pieces in a row do not say which way their plane leans.
    return plane if plane.normal_world @ guess.normal_world > np.cos(np.deg2rad(15.0)) else None
