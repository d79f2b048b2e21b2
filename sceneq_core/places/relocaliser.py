"""Where a frame of reference lies in a scene, from keyframes that were taken at known places."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.ingest.transforms import angle_deg, inverse, nearest_rigid, rotation_of, transform
from sceneq_core.places.atlas import Atlas, Known
from sceneq_core.places.place import Place
from sceneq_core.places.sighting import Sighting, SightingParams

MOST_TRUST = 0.98
"""Of surface that fits nobody can say more surely that it is the same."""
MOST_SIGHTINGS, MOST_SEEN = 2048, 64
"""Older ones are let go: a frame of reference that was not found by then drifts too much."""


@dataclass(frozen=True, slots=True)
class RelocaliserParams:
    """When keyframes recognised are believed.

    ``min_keyframes`` of them have to agree on where the frame of reference lies: what they say of
    the camera of each differs by ``near_m`` and ``near_deg`` at most, which is drift and errors of
    alignments. Another answer that ``rival_share`` as many give, or more, makes it ambiguous.
    """

    min_keyframes: int = 3
    near_m: float = 0.1
    near_deg: float = 3.0
    rival_share: float = 0.5
    sighting: SightingParams = field(default_factory=SightingParams)

    def __post_init__(self) -> None:
        need_at_least(self, 1, "min_keyframes")
        need_positive(self, "near_m", "near_deg")
        need_between(self, 0, 1, "rival_share")


@dataclass(frozen=True, slots=True)
class Relocation:
    """``T_world_odom`` (4, 4) and what it rests on: ``keyframes`` recognised at ``places``.

    ``features`` agree with it in all, ``trust`` is the median of the alignments, ``spread_m`` the
    median distance of what single keyframes say.
    """

    T_world_odom: Float64
    keyframes: int
    places: int
    features: int
    trust: float
    spread_m: float


@dataclass(frozen=True, slots=True)
class Standing:
    """How far it has come: keyframes ``seen``, those ``recognised`` anywhere, the most of them
    that agree with each other, and those that agree on another answer (``rivals``).
    """

    seen: int
    recognised: int
    agreeing: int
    rivals: int


class Relocaliser:
    """Collects what keyframes of one frame of reference say of where it lies."""

    def __init__(self, params: RelocaliserParams, atlas: Atlas | None = None) -> None:
        """``atlas``: the places of the scene, where several relocalisers share them."""
        self._params = params
        self._atlas = Atlas(params.sighting) if atlas is None else atlas
        self._sightings: list[Sighting] = []
        self._seen: dict[int, Known] = {}
        self._again: dict[int, frozenset[int]] = {}
        self._count = 0
        self.standing = Standing(0, 0, 0, 0)

    @property
    def has_to_look(self) -> bool:
        """Whether something that was seen is to be compared with places that are new."""
        return bool(self._again)

    def learn(self, places: Sequence[Place]) -> None:
        """Let ``places`` be those of the scene; what was seen is to be compared with new ones."""
        self.renew(self._atlas.learn(places))

    def renew(self, changed: frozenset[int]) -> None:
        """Take note that the atlas knows these places anew, elsewhere, or no more."""
        if not changed:
            return
        self._sightings = [s for s in self._sightings if s.place_seq not in changed]
        for seq in self._seen:
            self._again[seq] = self._again.get(seq, frozenset()) | changed

    def see(self, seen: Place) -> Relocation | None:
        """Take a keyframe, its pose in the unknown frame; return where that lies once it is sure.

        ``None``: too few keyframes were recognised, or they do not agree on one answer.
        """
        self._count += 1
        self._sightings = [s for s in self._sightings if s.seen_seq != seen.seq]
        known = self._seen[seen.seq] = self._atlas.look(seen)
        if len(self._seen) > MOST_SEEN:
            oldest = next(iter(self._seen))
            del self._seen[oldest]
            self._again.pop(oldest, None)
        return self._recognise(known, None)

    def look_again(self) -> Relocation | None:
        """Compare one of the last keyframes with the places that are new; as ``see``."""
        if not self._again:
            return None
        seq = next(iter(self._again))
        return self._recognise(self._seen[seq], self._again.pop(seq))

    def _recognise(self, seen: Known, among: frozenset[int] | None) -> Relocation | None:
        found = self._atlas.sightings(seen, among)
        self._sightings = (self._sightings + found)[-MOST_SIGHTINGS:]
        return self.answer()

    def answer(self) -> Relocation | None:
        """Return what all keyframes so far say together, ``None`` as long as that is not sure."""
        best = self._largest(self._sightings)
        rest = [s for s in self._sightings if all(s is not other for other in best)]
        rivals = self._largest(rest)
        agreeing, rival = _keyframes(best), _keyframes(rivals)
        self.standing = Standing(self._count, _keyframes(self._sightings), agreeing, rival)
        if agreeing < self._params.min_keyframes or rival >= self._params.rival_share * agreeing:
            return None
        return _relocation(best)

    def _largest(self, sightings: Sequence[Sighting]) -> list[Sighting]:
        """Return the sightings that agree with the one that the most keyframes agree with."""
        best: list[Sighting] = []
        worth = (0, 0)
        for centre in sightings:
            near = [s for s in sightings if self._agree(centre, s)]
            count = (_keyframes(near), sum(s.features for s in near))
            if count > worth:
                best, worth = near, count
        return best

    def _agree(self, one: Sighting, other: Sighting) -> bool:
        if angle_deg(one.T_world_odom, other.T_world_odom) > self._params.near_deg:
            return False
        return _apart_m(one, other) <= self._params.near_m


def _apart_m(one: Sighting, other: Sighting) -> float:
    """Return how far apart two sightings put the cameras that made them, metres."""
    cameras = np.stack((one.camera_odom, other.camera_odom))
    apart = transform(one.T_world_odom, cameras) - transform(other.T_world_odom, cameras)
    return float(np.linalg.norm(apart, axis=1).max())


def _keyframes(sightings: Sequence[Sighting]) -> int:
    return len({sighting.seen_seq for sighting in sightings})


def _relocation(sightings: Sequence[Sighting]) -> Relocation:
    T_world_odom = fused(sightings)
    cameras = np.stack([s.camera_odom for s in sightings])
    said = np.stack([transform(s.T_world_odom, s.camera_odom) for s in sightings])
    return Relocation(
        T_world_odom,
        _keyframes(sightings),
        len({s.place_seq for s in sightings}),
        sum(s.features for s in sightings),
        float(np.median([s.trust for s in sightings])),
        float(np.median(np.linalg.norm(said - transform(T_world_odom, cameras), axis=1))),
    )


def fused(sightings: Sequence[Sighting]) -> Float64:
    """Return T_world_odom (4, 4) that fits all sightings best, each by its information and trust.

    Small motions are added up about the middle of the cameras, where they are smallest; what
    contradicts the rest counts less (Huber), for an alignment may have slid along a wall. The
    information knows the noise of a depth, not what was taken for the same surface and is not: the
    odds of the trust do.
    """
    T_world_odom = sightings[0].T_world_odom
    for _ in range(10):
        centre = transform(T_world_odom, np.stack([s.camera_odom for s in sightings])).mean(axis=0)
        matrix, vector = np.eye(6) * 1e-6, np.zeros(6)
        steps = [_small(s.T_world_odom @ inverse(T_world_odom), centre) for s in sightings]
        for sighting, step in zip(sightings, steps, strict=True):
            information = _about(sighting.information, centre)
            weight = 1.0 / max(1.0, float(np.linalg.norm(step)) / 0.01)
            weight *= sighting.trust / (1.0 - min(sighting.trust, MOST_TRUST))
            matrix += weight * information
            vector += weight * information @ step
        found = np.asarray(np.linalg.solve(matrix, vector), np.float64)
        T_world_odom = nearest_rigid(_motion(found, centre) @ T_world_odom)
        if np.abs(found).max() < 1e-6:
            break
    return T_world_odom


def _small(T_new_old: Float64, centre: Float64) -> Float64:
    """Return a small motion (6,) of rotation and translation about ``centre``."""
    R_new_old = T_new_old[:3, :3]
    skew = 0.5 * (R_new_old - R_new_old.T)
    turn = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    return np.concatenate((turn, transform(T_new_old, centre) - centre))


def _motion(step: Float64, centre: Float64) -> Float64:
    T_new_old = np.eye(4)
    T_new_old[:3, :3] = rotation_of(step[:3])
    T_new_old[:3, 3] = centre + step[3:] - T_new_old[:3, :3] @ centre
    return T_new_old


def _about(information: Float64, centre: Float64) -> Float64:
    """Return information (6, 6) about the world's origin as that about ``centre``."""
    x, y, z = centre
    # A motion (w, t) about the centre is (w, t - w x centre) about the origin.
    shift = np.eye(6)
    shift[3:, :3] = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    about: Float64 = shift.T @ information @ shift
    return about
