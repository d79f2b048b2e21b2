"""One keyframe recognised at one place, and what that says of where the others are."""

from dataclasses import dataclass, field

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least, need_between
from sceneq_core.ingest.alignment import Alignment, AlignmentParams, align_views
from sceneq_core.ingest.depth_view import DepthView, DepthViewParams
from sceneq_core.ingest.transforms import inverse, nearest_rigid
from sceneq_core.places.features import FeatureParams
from sceneq_core.places.place import Place
from sceneq_core.places.rigid_fit import FitParams


@dataclass(frozen=True, slots=True)
class SightingParams:
    """When a keyframe counts as taken at a place.

    ``candidates`` places are looked at, those that share the most features, ``min_shared`` at
    least; ``min_features`` have to agree on one motion. After surfaces are aligned, ``min_overlap``
    of the keyframe has to fall on the place's surface and be trusted by ``min_trust`` (see
    ``Alignment``), or, where both are too plain to tell, ``min_inliers`` of it lie there.
    """

    candidates: int = 6
    min_shared: int = 5
    min_features: int = 10
    min_overlap: float = 0.2
    min_trust: float = 0.55
    min_inliers: float = 0.8
    features: FeatureParams = field(default_factory=FeatureParams)
    fit: FitParams = field(default_factory=FitParams)
    depth: DepthViewParams = field(default_factory=DepthViewParams)
    alignment: AlignmentParams = field(default_factory=lambda: AlignmentParams(reach_m=0.04))

    def __post_init__(self) -> None:
        need_at_least(self, 1, "candidates")
        need_at_least(self, 3, "min_shared", "min_features")
        need_between(self, 0, 1, "min_overlap", "min_trust", "min_inliers")


@dataclass(frozen=True, slots=True)
class Sighting:
    """Keyframe ``seen_seq`` of an unknown frame of reference was taken at place ``place_seq``.

    ``T_world_odom`` (4, 4) is where that frame lies then; ``camera_odom`` (3,) the camera in it.
    ``features`` that agree, ``trust`` of the alignment, and its ``information`` (6, 6) of rotation
    (rad) and translation (m) about the axes of the world.
    """

    seen_seq: int
    place_seq: int
    T_world_odom: Float64
    camera_odom: Float64
    features: int
    trust: float
    information: Float64


def confirmed(
    seen: Place,
    view: DepthView,
    place: Place,
    T_place_seen: Float64,
    agreeing: int,
    params: SightingParams,
) -> Sighting | None:
    """Return the sighting that the guess ``T_place_seen`` leads to, if the surfaces fit."""
    found = align_views(view, place.view(params.depth), T_place_seen, params.alignment)
    if not _fits(found, params):
        return None
    T_world_odom = place.T_world_camera @ found.T_target_source @ inverse(seen.T_world_camera)
    return Sighting(
        seen.seq,
        place.seq,
        nearest_rigid(T_world_odom),
        seen.T_world_camera[:3, 3].copy(),
        agreeing,
        found.inliers if np.isnan(found.likeness) else found.trust,
        information_about(place.T_world_camera, found.information),
    )


def information_about(T_world_place: Float64, information: Float64) -> Float64:
    """Return information (6, 6) about the axes of a place as that about those of the world."""
    rotation, (x, y, z) = T_world_place[:3, :3], T_world_place[:3, 3]
    adjoint = np.zeros((6, 6))
    adjoint[:3, :3] = adjoint[3:, 3:] = rotation
    adjoint[3:, :3] = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]]) @ rotation
    back = np.linalg.inv(adjoint)
    about: Float64 = back.T @ information @ back
    return about


def _fits(found: Alignment, params: SightingParams) -> bool:
    plain = np.isnan(found.likeness) and found.inliers >= params.min_inliers
    return found.overlap >= params.min_overlap and bool(plain or found.trust >= params.min_trust)
