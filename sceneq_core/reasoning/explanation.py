"""Why a target was chosen, or none, in words."""

from collections.abc import Sequence

import numpy as np

from sceneq_core.arrays import Float64, Int64
from sceneq_core.reasoning.english import counted, listed, ordinal, relation_words
from sceneq_core.reasoning.holding import Holding, relative
from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem
from sceneq_core.reasoning.relations import RELATIONS
from sceneq_core.reasoning.superlatives import COMPARED_TO_ANCHOR, SIDEWAYS, SUPERLATIVES

REAL = 0.5
"""From which p relative to the likeliest a candidate is spoken of as such a thing."""


def nothing_to_decide_by() -> str:
    """Say why candidates without a constraint stay undecided."""
    return "which one? the question names no relation or size to decide by"


def no_candidates(problem: Problem) -> str:
    """Say that nothing was there to choose from."""
    return f"nothing in the map may be '{problem.target}'"


def no_names() -> str:
    """Say that geometry has no opinion on what a thing is called."""
    return "as the encoder names it: geometry knows no names"


def none_holds(problem: Problem) -> str:
    """Say that no candidate satisfies the constraints."""
    wanted = " and ".join(_said(constraint, None) for constraint in problem.constraints)
    return f"none of the candidates for '{problem.target or 'anything'}' is {wanted}"


def why(
    problem: Problem, targets: Sequence[Candidate], score: Float64, holdings: Sequence[Holding]
) -> str:
    """Name the winner, what made it win, and how far the next like it was from that."""
    order = np.argsort(-score, kind="stable")
    real = order[relative([target.p for target in targets])[order] >= REAL]
    winner = targets[order[0]]
    parts = [_holding(holding, int(order[0]), real) for holding in holdings]
    alike = ""
    if problem.target and len(real) > 1:
        sure = sum(targets[i].p for i in real) >= REAL
        many = counted(len(real), problem.target)
        alike = f"{many}; " if sure else f"{len(real)} may be '{problem.target}'; "
    return f"{alike}{_named(winner, problem.target or winner.label)} is {listed(parts)}"


def _holding(holding: Holding, best: int, real: Int64) -> str:
    said = _said(holding.constraint, holding.anchor[best])
    others = [int(i) for i in real if i != best]
    if holding.amount is not None:
        said += f", {holding.amount[best]:.2g} {holding.unit}"
        if others:
            other = "the other" if len(others) == 1 else "the next"
            said += f", {other} {holding.amount[others[0]]:.2g}"
    if holding.standpoint is not None:
        said += f", {_seen(holding)}"
    return said


def _seen(holding: Holding) -> str:
    """State the frame that left and right are meant in."""
    constraint = holding.constraint
    thing = holding.standpoint.thing if holding.standpoint else None
    if thing is None:
        return "seen from the viewer"
    if constraint.seen_from:
        return f"seen from {_named(thing, constraint.seen_from)}"
    return f"seen by the viewer facing {_named(thing, constraint.facing)}"


def _named(candidate: Candidate, words: str) -> str:
    return f"instance {candidate.instance_id} ('{words}')"


def _said(constraint: Constraint, anchor: Candidate | None) -> str:
    words = relation_words(constraint.relation)
    if constraint.relation in SUPERLATIVES or constraint.relation in SIDEWAYS:
        rank = f"{ordinal(constraint.rank)} " if constraint.rank > 1 else ""
        words = f"the {rank}{words}"
    if constraint.negated:
        words = f"not {words}"
    if constraint.relation in COMPARED_TO_ANCHOR:
        words += " to" if constraint.relation == "nearest" else " from"
    other = f" and '{constraint.other}'" if constraint.other else ""
    if anchor is not None:
        return f"{words} {_named(anchor, constraint.anchor)}{other}"
    if constraint.anchor:
        return f"{words} '{constraint.anchor}'{other}"
    return f"{words} the viewer" if _needs_anchor(constraint.relation) else words


def _needs_anchor(relation: str) -> bool:
    return relation in RELATIONS or relation in COMPARED_TO_ANCHOR
