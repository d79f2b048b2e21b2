"""Keeps out of the map the keyframes that would harm it, and lets in those that prove right.

A keyframe whose images are broken is refused. One that contradicts what earlier keyframes saw, or
jumps to where nothing is known, is held back: when the following ones agree with it, the world (or
the place) has changed and all are let in; when they do not, it was a fault and is left out. After a
jump into contradiction, which is what a lost or restarted pose source looks like, the new claim
must have been made as often as all that it contradicts.
"""

from dataclasses import dataclass, field, replace

from sceneq_core.arrays import UInt16
from sceneq_core.checks import need_at_least, need_between, need_positive
from sceneq_core.frame import Frame
from sceneq_core.mapping.correction import Correction
from sceneq_core.mapping.frame_faults import FaultParams, depth_cut, fault
from sceneq_core.mapping.reference_view import ReferenceParams, ReferenceView
from sceneq_core.mapping.witnesses import Motion, Witnesses, compare
from sceneq_core.visits import visit_of

Keyframe = tuple[Frame, UInt16]


@dataclass(frozen=True, slots=True)
class QuarantineParams:
    """When a keyframe is held back, and when it is let in after all.

    Of the samples that earlier keyframes know about, ``min_agreement`` must agree; after a motion
    faster than ``max_speed_m_s`` or ``max_turn_rad_s`` (brisk for a hand, fast for a robot indoors)
    ``min_agreement_jump``, and ``min_cover_jump`` of the frame must be known surface. With less
    than ``min_overlap`` of a frame's samples known nothing can be said. A new claim is believed
    after ``confirm_views`` keyframes in agreement, and over ``confirm_s`` where it contradicts what
    is known; ``max_held`` of them are kept to be let in later. Below ``lost_agreement`` after a
    jump it is not furniture that moved but the pose that is lost. ``witnesses`` nearby views of at
    most ``max_views`` are asked, one each ``place_m``.
    """

    enabled: bool = True
    min_agreement: float = 0.9
    min_agreement_jump: float = 0.95
    min_cover_jump: float = 0.5
    lost_agreement: float = 0.7
    max_speed_m_s: float = 1.5
    max_turn_rad_s: float = 2.0
    min_overlap: float = 0.1
    confirm_views: int = 3
    confirm_s: float = 0.5
    max_held: int = 6
    witnesses: int = 6
    max_views: int = 256
    place_m: float = 0.4
    faults: FaultParams = field(default_factory=FaultParams)
    reference: ReferenceParams = field(default_factory=ReferenceParams)

    def __post_init__(self) -> None:
        need_between(self, 0, 1, "min_agreement", "min_agreement_jump", "min_overlap")
        need_between(self, 0, 1, "min_cover_jump", "lost_agreement")
        need_positive(self, "max_speed_m_s", "max_turn_rad_s", "place_m")
        need_at_least(self, 2, "confirm_views")
        need_at_least(self, 1, "max_held", "witnesses", "max_views")
        need_at_least(self, 0, "confirm_s")


@dataclass(frozen=True, slots=True)
class Admission:
    """Which keyframes go into the map now, oldest first, or the ``reason`` why none does.

    A reason is "kind: details", or the kind alone.
    """

    keyframes: tuple[Keyframe, ...] = ()
    reason: str = ""


@dataclass(slots=True)
class _Claim:
    """Consecutive keyframes that agree with each other but not with what is known.

    ``jumped`` there faster than a camera moves; ``contradicts`` what is known rather than adds to
    it, with the worst ``agreement`` of all views.
    """

    jumped: bool
    contradicts: bool
    agreement: float
    since_ns: int
    last: ReferenceView
    views: int = 1
    keyframes: list[Keyframe] = field(default_factory=list)


class Quarantine:
    """Decides on every keyframe. Same keyframes, same order: same decisions.

    What jumps and what follows is judged within a visit; what contradicts the map, by all of them.

    Attributes:
        let_in: keyframes held back first and let in later.
    """

    def __init__(self, params: QuarantineParams) -> None:
        self._params = params
        self._witnesses = Witnesses(params.witnesses, params.max_views, params.place_m)
        self._last_of: dict[int, ReferenceView] = {}
        self._admitted = 0
        self.let_in = 0
        self._cut_views = 0
        self._claim_of: dict[int, _Claim] = {}

    def admit(self, frame: Frame, label_image: UInt16) -> Admission:
        """Return what goes into the map now that ``frame`` came."""
        if not self._params.enabled:
            return Admission(((frame, label_image),))
        broken = fault(frame, self._params.faults) or self._cut(frame)
        if broken:
            return Admission(reason=broken)
        view = ReferenceView(frame, self._params.reference)
        reason, claim = self._doubt(view)
        if reason:
            return self._hold(claim, reason, (frame, label_image))
        proven = self._proven_by(view)
        self._remember(view)
        return Admission((*proven, (frame, label_image)))

    def correct(self, correction: Correction) -> None:
        """Move the views of frames whose poses are known better now."""
        poses = dict(zip(correction.seq.tolist(), correction.T_world_camera, strict=True))
        self._witnesses.correct(poses)
        for visit, last in self._last_of.items():
            if last.seq in poses:
                self._last_of[visit] = last.moved(poses[last.seq])
        for claim in self._claim_of.values():
            claim.keyframes = [
                (replace(frame, T_world_camera=poses.get(frame.seq, frame.T_world_camera)), labels)
                for frame, labels in claim.keyframes
            ]
            claim.last = ReferenceView(claim.keyframes[-1][0], self._params.reference)

    def _cut(self, frame: Frame) -> str:
        """Return how much depth is missing, until it is clear that the sensor is like that."""
        reason = depth_cut(frame, self._params.faults)
        self._cut_views = self._cut_views + 1 if reason else 0
        return reason if self._cut_views < self._params.confirm_views else ""

    def _doubt(self, view: ReferenceView) -> tuple[str, _Claim]:
        """Return what speaks against ``view``, empty when nothing does."""
        params = self._params
        known = self._witnesses.ask(view)
        visit = visit_of(view.seq)
        last = self._last_of.get(visit)
        motion = Motion.between(last, view) if last else Motion(0.0, 0.0, 0.0)
        jumped = motion.exceeds(params.max_speed_m_s, params.max_turn_rad_s)
        needed = params.min_agreement_jump if jumped else params.min_agreement
        overlaps = known.samples >= params.min_overlap * max(1, len(view.points_world))
        contradicts = overlaps and known.agreement < needed
        lost = not overlaps and visit in self._claim_of
        uncovered = lost or (jumped and known.cover < params.min_cover_jump)
        reasons = (
            f"map contradicted: {1.0 - known.agreement:.0%} of what is known there" * contradicts,
            f"pose jumped: {motion}" * (uncovered or (jumped and contradicts)),
        )
        claim = _Claim(jumped, contradicts, known.agreement, view.stamp_ns, view)
        return ", ".join(filter(None, reasons)), claim

    def _hold(self, new: _Claim, reason: str, keyframe: Keyframe) -> Admission:
        """Let ``new`` continue the claim it agrees with, or replace it; admit what is believed."""
        claim = self._claim_of.get(visit_of(new.last.seq))
        if claim is None or not self._follows(claim.last, new.last):
            claim = self._claim_of[visit_of(new.last.seq)] = new
        else:
            claim.views += 1
            claim.last = new.last
            claim.contradicts |= new.contradicts
            claim.agreement = min(claim.agreement, new.agreement)
        claim.keyframes.append(keyframe)
        del claim.keyframes[: -self._params.max_held]
        if not self._lasting(claim):
            return Admission(reason=reason)
        lost = claim.jumped and claim.agreement < self._params.lost_agreement
        if lost and claim.contradicts and claim.views < self._admitted:
            return Admission(reason=f"pose lost: for {claim.views} keyframes, {reason}")
        return Admission(self._believe(claim, held=len(claim.keyframes) - 1))

    def _proven_by(self, view: ReferenceView) -> tuple[Keyframe, ...]:
        """Return the keyframes held for a jump that a good ``view`` confirms: it was just fast."""
        claim = self._claim_of.pop(visit_of(view.seq), None)
        if claim is None or claim.contradicts:
            return ()
        common = compare(view, (claim.last,))
        confirmed = common.cover >= self._params.min_overlap
        confirmed &= common.agreement >= self._params.min_agreement_jump
        return self._believe(claim, held=len(claim.keyframes)) if confirmed else ()

    def _follows(self, earlier: ReferenceView, later: ReferenceView) -> bool:
        params = self._params
        motion, common = Motion.between(earlier, later), compare(later, (earlier,))
        near = not motion.exceeds(params.max_speed_m_s, params.max_turn_rad_s)
        near |= common.cover >= params.min_cover_jump
        return near and common.agreement >= params.min_agreement_jump

    def _lasting(self, claim: _Claim) -> bool:
        """Tell whether enough keyframes make the claim; without a contradiction two are enough."""
        if not claim.contradicts:
            return claim.views >= 2
        seconds = abs(claim.last.stamp_ns - claim.since_ns) * 1e-9
        return claim.views >= self._params.confirm_views and seconds >= self._params.confirm_s

    def _believe(self, claim: _Claim, held: int) -> tuple[Keyframe, ...]:
        self._claim_of.pop(visit_of(claim.last.seq), None)
        self.let_in += held
        for frame, _ in claim.keyframes:
            view = ReferenceView(frame, self._params.reference)
            self._witnesses.overrule(view, self._params.min_agreement_jump)
            self._remember(view)
        return tuple(claim.keyframes)

    def _remember(self, view: ReferenceView) -> None:
        self._witnesses.add(view)
        self._last_of[visit_of(view.seq)] = view
        self._admitted += 1
