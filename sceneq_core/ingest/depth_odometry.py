"""Odometry from depth images alone, against the last image that differs enough."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from sceneq_core.arrays import Float64, UInt16
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.ingest.alignment import Alignment, AlignmentParams, align_views
from sceneq_core.ingest.depth_view import DepthView, DepthViewParams, depth_view, thin_depth
from sceneq_core.ingest.shading import Shading
from sceneq_core.ingest.transforms import angle_deg, distance_m, inverse, nearest_rigid, rotation_of

SAME_M, SAME_DEG = 0.06, 3.0
"""Alignments on the coarsest level that differ by less come to the same place in full."""


SLIDES = 3


@dataclass(frozen=True, slots=True)
class DepthOdometryParams:
    """When an image is trusted, and when it becomes the next reference.

    The images are aligned with the reference, so errors add up per reference, not per image: it
    changes after ``reference_m`` metres, ``reference_deg`` degrees or when less than
    ``reference_overlap`` of an image is in it.

    An image that is found with ``clear_trust`` (see ``Alignment``) is there. So is one too plain to
    tell, within ``expected_m`` and ``expected_deg`` of constant motion and with ``plain_overlap``
    and ``plain_inliers``. Else turns of up to ``search_deg`` in steps of ``search_step_deg`` are
    tried, the best ``search_best`` of them in full, with ``search_reach_m`` in place of the usual
    reach, then places ``slide_m`` beside; the most promising one needs ``min_trust``. With less,
    an overlap below ``min_overlap`` or fewer than ``min_points`` oriented points tracking is lost;
    after ``search_tries`` such images in a row turns are tried only at every ``search_tries``-th.
    """

    reference_m: float = 0.15
    reference_deg: float = 12.0
    reference_overlap: float = 0.6
    expected_m: float = 0.1
    expected_deg: float = 8.0
    min_overlap: float = 0.25
    clear_trust: float = 0.65
    min_trust: float = 0.5
    plain_overlap: float = 0.5
    plain_inliers: float = 0.6
    min_points: int = 300
    search_deg: float = 36.0
    search_step_deg: float = 12.0
    search_best: int = 8
    search_reach_m: float = 0.12
    search_tries: int = 5
    slide_m: float = 0.15
    view: DepthViewParams = field(default_factory=DepthViewParams)
    alignment: AlignmentParams = field(default_factory=AlignmentParams)

    def __post_init__(self) -> None:
        need_positive(self, "reference_m", "reference_deg", "search_step_deg")
        need_positive(self, "search_reach_m", "slide_m", "expected_m", "expected_deg")
        need_between(self, 0, 1, "reference_overlap", "min_overlap", "min_trust", "clear_trust")
        need_between(self, 0, 1, "plain_overlap", "plain_inliers")
        need_at_least(self, 6, "min_points")
        need_at_least(self, 1, "search_best", "search_tries")
        need_at_least(self, 0, "search_deg")


class DepthOdometry:
    """Point-to-plane alignment of each depth image with a reference image."""

    Params: ClassVar[type] = DepthOdometryParams
    kind = "depth_icp"

    def __init__(self, params: DepthOdometryParams) -> None:
        self.params = params
        self._reference: DepthView | None = None
        self._last: DepthView | None = None
        self._T_world_reference = np.eye(4)
        self._T_world_last = np.eye(4)
        self._T_last_next = np.eye(4)
        self._lost = 0

    def register(
        self, depth_mm: UInt16, K: Float64, stamp_ns: int, shading: Shading | None = None
    ) -> Float64 | None:
        """Return T_world_camera (4, 4) of the depth camera; ``None`` when tracking is lost.

        It then goes on from where it was last sure. Images are taken as equally spaced in time.
        """
        params = self.params
        view = depth_view(*thin_depth(depth_mm, K, params.view), params.view).shaded(shading)
        if view.count < params.min_points:
            return None
        if self._reference is None or self._last is None:
            self._reference = self._last = view
            return self._T_world_last
        found = self._find(view, self._reference, self._last)
        if found is None:
            self._lost += 1
            self._T_last_next = np.eye(4)
            return None
        self._lost = 0
        return self._move(view, found)

    def _find(self, view: DepthView, reference: DepthView, last: DepthView) -> Alignment | None:
        """Return where ``view`` is; look around unless it is clearly where it is expected.

        After looking around the last image is the reference: it shows most of what this one does.
        """
        expected = inverse(self._T_world_reference) @ self._T_world_last @ self._T_last_next
        found = align_views(view, reference, expected, self.params.alignment)
        if self._is_clear(found, expected):
            return found
        tries = self.params.search_tries
        if self._lost < tries or self._lost % tries == 0:
            elsewhere = self._look_around(view, last)
            if _promise(elsewhere) > _promise(found):
                self._reference, self._T_world_reference = last, self._T_world_last
                found = elsewhere
        is_sure = found.overlap >= self.params.min_overlap and found.trust >= self.params.min_trust
        return found if is_sure else None

    def _is_clear(self, found: Alignment, expected: Float64) -> bool:
        """Tell whether nothing better need be looked for; surfaces alone only where expected."""
        params = self.params
        if not np.isnan(found.likeness):
            return found.overlap >= params.min_overlap and found.trust >= params.clear_trust
        return (
            found.overlap >= params.plain_overlap
            and found.inliers >= params.plain_inliers
            and distance_m(found.T_target_source, expected) <= params.expected_m
            and angle_deg(found.T_target_source, expected) <= params.expected_deg
        )

    def _look_around(self, view: DepthView, last: DepthView) -> Alignment:
        """Return the best alignment from turns of the camera tried on the coarsest level."""
        params = self.params
        wide = replace(params.alignment, reach_m=params.search_reach_m)
        coarse = [align_views(view.coarse, last.coarse, turn, wide) for turn in self._turns()]
        fine = []
        for found in _distinct(coarse)[: params.search_best]:
            near = align_views(view, last, found.T_target_source, wide)
            fine.append(align_views(view, last, near.T_target_source, params.alignment))
        found = max(fine, key=_promise)
        return found if found.trust >= params.clear_trust else self._slide(view, last, found)

    def _slide(self, view: DepthView, last: DepthView, found: Alignment) -> Alignment:
        """Return the most promising alignment beside ``found``.

        Along walls and floors surfaces fit anywhere: only the picture tells where they belong.
        """
        for _ in range(SLIDES):
            beside = [found]
            for axis in (*np.eye(3), *-np.eye(3)):
                guess = found.T_target_source.copy()
                guess[:3, 3] += self.params.slide_m * axis
                beside.append(align_views(view, last, guess, self.params.alignment))
            best = max(beside, key=_promise)
            if best is found:
                break
            found = best
        return found

    def _turns(self) -> list[Float64]:
        step, most = self.params.search_step_deg, self.params.search_deg
        angles = np.deg2rad(np.arange(-most, most + step / 2, step))
        turns = []
        for yaw in angles:
            for pitch in angles[np.abs(angles) <= np.deg2rad(most) / 2]:
                turn = np.eye(4)
                turn[:3, :3] = rotation_of(np.array([0.0, yaw, 0.0])) @ rotation_of(
                    np.array([pitch, 0.0, 0.0])
                )
                turns.append(turn)
        return turns

    def _move(self, view: DepthView, found: Alignment) -> Float64:
        params = self.params
        T_world_camera = nearest_rigid(self._T_world_reference @ found.T_target_source)
        self._T_last_next = inverse(self._T_world_last) @ T_world_camera
        self._last, self._T_world_last = view, T_world_camera
        moved = distance_m(self._T_world_reference, T_world_camera) >= params.reference_m
        turned = angle_deg(self._T_world_reference, T_world_camera) >= params.reference_deg
        if moved or turned or found.overlap < params.reference_overlap:
            self._reference, self._T_world_reference = view, T_world_camera
        return T_world_camera


def _distinct(found: list[Alignment]) -> list[Alignment]:
    """Return the alignments, best fit first, without those that many turns came to."""
    kept: list[Alignment] = []
    for one in sorted(found, key=lambda one: -one.overlap * one.inliers):
        T_one = one.T_target_source
        if not any(
            distance_m(T_one, other.T_target_source) < SAME_M
            and angle_deg(T_one, other.T_target_source) < SAME_DEG
            for other in kept
        ):
            kept.append(one)
    return kept


def _promise(found: Alignment) -> float:
    """Return how likely an alignment is the right one, to choose by."""
    return found.overlap * found.inliers * float(np.nan_to_num(max(found.likeness, 0.01), nan=0.01))
