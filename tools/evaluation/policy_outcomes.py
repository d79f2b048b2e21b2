"""What the encoder and a reasoner make of every question: all that a policy can choose between."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.evaluation.null_fit import fit_logistic
from sceneq_core.routing.judge import JudgeParams
from sceneq_core.routing.outlook import KINDS, Skill, log_odds
from sceneq_core.routing.policy import Case, case_of
from sceneq_core.routing.router import Router
from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.recording_pictures import pictures_of
from sceneq_tools.evaluation.retrieval import is_right
from sceneq_tools.evaluation.retrieval_asking import ALWAYS, NONE, Answered, Asking
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Query
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.simulated_vlm import SimulatedVlm

SCALES = (0.25, 0.5, 1.0, 1.25, 1.5)
"""Of the gate's thresholds: how strict it is beside the configured one."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """One question: what a policy sees of it, and what would come of either decision.

    ``passes``: whether the encoder's answer passes the gate, by ``SCALES``. ``calls`` is what the
    reasoner's answer costs; one that makes no calls counts as one.
    """

    recording: str
    case: Case
    passes: Mapping[float, bool]
    fast_right: bool
    reasoned_right: bool
    changed: bool
    calls: int


def outcomes_of(
    scenes: Sequence[Scene], setup: Setup, accuracy: float | None, seed: int
) -> list[Outcome]:
    """Ask everything twice, without and with a reasoner: the graph's, or a simulated model."""
    gates = {scale: _scaled(setup, scale) for scale in SCALES}
    return [one for scene in scenes for one in _outcomes(scene, setup, gates, accuracy, seed)]


def skills_of(outcomes: Sequence[Outcome]) -> dict[str, Skill]:
    """Return how often the reasoner mended and kept answers, by kind; an opinion fills gaps."""
    return {kind: _skill([one for one in outcomes if one.case.kind == kind]) for kind in KINDS}


def _outcomes(
    scene: Scene,
    setup: Setup,
    gates: Mapping[float, Router],
    accuracy: float | None,
    seed: int,
) -> list[Outcome]:
    candidates, name = scene.candidates, scene.questioned.name
    pictures = pictures_of(scene.questioned.folder)
    rows = []
    for query in scene.questioned.queries:
        if accuracy is not None:
            right = _right(candidates, query)
            model = SimulatedVlm(right, accuracy, f"{seed} {name} {query.text}")
            setup = replace(setup, reasoner=model)
        asking = Asking(setup, candidates.snapshot, pictures)
        fast, reasoned = asking.ask(query, NONE), asking.ask(query, ALWAYS)
        rows.append(_outcome(name, candidates, query, gates, fast, reasoned))
    return rows


def _outcome(
    name: str,
    candidates: Candidates,
    query: Query,
    gates: Mapping[float, Router],
    fast: Answered,
    reasoned: Answered,
) -> Outcome:
    targets = _right(candidates, query)
    question = gates[1.0].read(query.text)
    routed = {scale: gate.answer(candidates.snapshot, question) for scale, gate in gates.items()}
    said = [(one.is_not_found, one.is_not_found or one.ranked[:1]) for one in (fast, reasoned)]
    return Outcome(
        recording=name,
        case=case_of(routed[1.0], question),
        passes={scale: one.enough for scale, one in routed.items()},
        fast_right=is_right(fast, targets, 1),
        reasoned_right=is_right(reasoned, targets, 1),
        changed=said[0] != said[1],
        calls=max(reasoned.vlm_calls, 1),
    )


def _right(candidates: Candidates, query: Query) -> frozenset[int]:
    """Return the candidates that are what is asked for, by their first rule of a hit."""
    matches = next(iter(candidates.matches.values()))
    return frozenset(one for target in query.targets for one in matches.get(target, ()))


def _scaled(setup: Setup, scale: float) -> Router:
    """Return the router with every threshold of its judge so many times as strict."""
    router = setup.router
    judge = _scaled_judge(router.params.judge, scale)
    return Router(replace(router.params, judge=judge), setup.tempered, router.labeller)


def _scaled_judge(judge: JudgeParams, scale: float) -> JudgeParams:
    gate = judge.gate
    return replace(
        judge,
        gate=replace(
            gate,
            min_p=min(1.0, gate.min_p * scale),
            min_margin=min(1.0, gate.min_margin * scale),
            clear_margin=min(1.0, gate.clear_margin * scale),
            max_entropy_norm=max(0.0, 1.0 - (1.0 - gate.max_entropy_norm) * scale),
        ),
        min_claim=min(1.0, judge.min_claim * scale),
        min_absence=min(1.0, judge.min_absence * scale),
    )


def _skill(outcomes: Sequence[Outcome]) -> Skill:
    usual = Skill()
    wrong = [one.reasoned_right for one in outcomes if not one.fast_right]
    right = [one.reasoned_right for one in outcomes if one.fast_right]
    measured = Skill(mends=_share(wrong, usual.mends), keeps=_share(right, usual.keeps))
    if not wrong or not right:
        return measured
    odds = np.array([log_odds(one.case.p_right) for one in outcomes], np.float64)
    fast_right = np.array([one.fast_right for one in outcomes], np.bool_)
    (scale, bias), _ = fit_logistic(odds[:, None], fast_right)
    return replace(measured, scale=float(min(scale, 10.0)), bias=float(np.clip(bias, -10.0, 10.0)))


def _share(yes: Sequence[bool], otherwise: float) -> float:
    return sum(yes) / len(yes) if yes else otherwise
