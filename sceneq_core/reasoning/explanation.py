"""Why a target was chosen, or none, in words."""

from collections.abc import Sequence

from sceneq_core.reasoning.reasoner import Candidate, Constraint, Problem
from sceneq_core.reasoning.relations import RELATIONS
from sceneq_core.reasoning.superlatives import COMPARED_TO_ANCHOR, SUPERLATIVES


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
    problem: Problem, winner: Candidate, holding: Sequence[tuple[Constraint, Candidate | None]]
) -> str:
    """Name the winner and, for each constraint, the anchor that made it win."""
    parts = [_said(constraint, anchor) for constraint, anchor in holding]
    return f"{_named(winner, problem.target or winner.label)} is {' and '.join(parts)}"


def _named(candidate: Candidate, words: str) -> str:
    return f"instance {candidate.instance_id} ('{words}')"


def _said(constraint: Constraint, anchor: Candidate | None) -> str:
    words = constraint.relation.replace("_", " ")
    if constraint.relation in SUPERLATIVES:
        words = f"the {words}"
    if constraint.relation in COMPARED_TO_ANCHOR:
        words += " to" if constraint.relation == "nearest" else " from"
    if anchor is not None:
        return f"{words} {_named(anchor, constraint.anchor)}"
    if constraint.anchor:
        return f"{words} '{constraint.anchor}'"
    return f"{words} the viewer" if _needs_anchor(constraint.relation) else words


def _needs_anchor(relation: str) -> bool:
    return relation in RELATIONS or relation in COMPARED_TO_ANCHOR
