"""Problems and verdicts as they travel between routing and reasoning: JSON, checked and bounded."""

import math
from typing import Any

from sceneq_core.reasoning.reasoner import (
    NO_USAGE,
    Box,
    Candidate,
    LabelProblem,
    LabelVerdict,
    Problem,
    UnansweredError,
    Usage,
    Verdict,
    Views,
)
from sceneq_nodes._constraint_json import constraint_from_json, constraint_json
from sceneq_nodes._json_fields import (
    MAX_TEXT,
    flag,
    integer,
    list_of,
    number,
    numbers,
    object_of,
    parse,
    probability,
    text_of,
    unit,
)
from sceneq_nodes._wire import json_bytes
from sceneq_schemas.errors import DecodeError

MAX_CANDIDATES = 256
MAX_CONSTRAINTS = 8
MAX_VIEWS = 16
MAX_NEIGHBOURS = 4096


def problem_bytes(problem: Problem) -> bytes:
    """Return the JSON of a problem."""
    return json_bytes(
        {
            "text": problem.text,
            "target": problem.target,
            "constraints": [constraint_json(c) for c in problem.constraints],
            "candidates": [_candidate_json(c) for c in problem.candidates],
            "up_world": problem.up_world.tolist(),
            "viewpoint_world": problem.viewpoint_world.tolist(),
            "time_s": _time_json(problem.time_s),
            "may_spend": problem.may_spend,
        }
    )


def label_problem_bytes(problem: LabelProblem) -> bytes:
    """Return the JSON of the question what an instance is called."""
    return json_bytes(
        {
            "label_of": problem.instance_id,
            "labels": [[name, p] for name, p in problem.labels],
            "views": _views_json(problem.views),
            "time_s": _time_json(problem.time_s),
            "may_spend": problem.may_spend,
        }
    )


def any_problem_from_bytes(data: bytes) -> Problem | LabelProblem:
    """Return the problem in ``data``, of either direction; raise ``DecodeError``."""
    wire = object_of(parse(data), "problem")
    if "label_of" not in wire:
        return _problem(wire)
    return LabelProblem(
        instance_id=integer(wire["label_of"], "label_of"),
        labels=tuple(list_of(wire, "labels", MAX_CANDIDATES, _named)),
        views=tuple(list_of(wire, "views", MAX_VIEWS, _view)),
        time_s=_time_s(wire),
        may_spend=flag(wire, "may_spend", otherwise=True),
    )


def problem_from_bytes(data: bytes) -> Problem:
    """Return the problem in ``data``; raise ``DecodeError`` naming what is wrong with it."""
    return _problem(object_of(parse(data), "problem"))


def _problem(wire: dict[str, Any]) -> Problem:
    return Problem(
        text=text_of(wire, "text"),
        target=text_of(wire, "target"),
        constraints=tuple(list_of(wire, "constraints", MAX_CONSTRAINTS, constraint_from_json)),
        candidates=tuple(list_of(wire, "candidates", MAX_CANDIDATES, _candidate)),
        up_world=unit(numbers(wire, "up_world", (3,))),
        viewpoint_world=numbers(wire, "viewpoint_world", (3,)),
        time_s=_time_s(wire),
        may_spend=flag(wire, "may_spend", otherwise=True),
    )


def verdict_bytes(verdict: Verdict | LabelVerdict | UnansweredError) -> bytes:
    """Return the JSON of a verdict, or of why there is none."""
    cost = {"vlm_calls": verdict.vlm_calls, "usage": _usage_json(verdict.usage)}
    if isinstance(verdict, UnansweredError):
        return json_bytes({"unanswered": str(verdict)[:MAX_TEXT], **cost})
    ranking = [[key, p] for key, p in verdict.ranking]
    return json_bytes({"ranking": ranking, "reason": verdict.reason[:MAX_TEXT], **cost})


def verdict_from_bytes(data: bytes) -> Verdict:
    """Return the verdict in ``data``.

    Raises:
        DecodeError: naming what is wrong with it.
        UnansweredError: it says that there is none.
    """
    wire = _answered(data)
    return Verdict(
        tuple(list_of(wire, "ranking", MAX_CANDIDATES, _ranked)), *_reason_and_cost(wire)
    )


def label_verdict_from_bytes(data: bytes) -> LabelVerdict:
    """Return what the instance is called; raises as ``verdict_from_bytes``."""
    wire = _answered(data)
    ranking = tuple(list_of(wire, "ranking", MAX_CANDIDATES, _named))
    return LabelVerdict(ranking, *_reason_and_cost(wire))


def _answered(data: bytes) -> dict[str, Any]:
    wire = object_of(parse(data), "verdict")
    if "unanswered" in wire:
        calls, usage = _cost(wire)
        raise UnansweredError(text_of(wire, "unanswered"), calls, usage)
    return wire


def _reason_and_cost(wire: dict[str, Any]) -> tuple[str, int, Usage]:
    return (text_of(wire, "reason"), *_cost(wire))


def _cost(wire: dict[str, Any]) -> tuple[int, Usage]:
    return integer(wire.get("vlm_calls"), "vlm_calls"), _usage(wire.get("usage"))


def _usage_json(usage: Usage) -> list[float]:
    return [usage.tokens_in, usage.tokens_out, usage.money]


def _usage(wire: Any) -> Usage:
    """A reasoner that uses no model may leave it out."""
    if wire is None:
        return NO_USAGE
    if not isinstance(wire, list) or len(wire) != 3:
        raise DecodeError("usage: expected [tokens_in, tokens_out, money]")
    tokens_in, tokens_out = (integer(value, "usage") for value in wire[:2])
    return Usage(tokens_in, tokens_out, number(wire[2], "usage"))


def _time_json(time_s: float) -> float | None:
    return time_s if math.isfinite(time_s) else None


def _time_s(wire: dict[str, Any]) -> float:
    value = wire.get("time_s")
    return math.inf if value is None else max(0.0, number(value, "time_s"))


def _candidate_json(candidate: Candidate) -> dict[str, Any]:
    return {
        "id": candidate.instance_id,
        "role": candidate.role,
        "words": candidate.words,
        "label": candidate.label,
        "p": candidate.p,
        "cosine": candidate.cosine,
        "centre_world": candidate.centre_world.tolist(),
        "T_world_box": candidate.T_world_box.tolist(),
        "box_size_m": candidate.box_size_m.tolist(),
        "views": _views_json(candidate.views),
        "supported_by": candidate.supported_by,
        "inside": candidate.inside,
        "neighbours": list(candidate.neighbours),
    }


def _views_json(views: Views) -> list[list[float]]:
    return [[seq, *box] for seq, box in views]


def _candidate(wire: Any) -> Candidate:
    wire = object_of(wire, "candidate")
    role = text_of(wire, "role")
    if role not in ("target", "anchor"):
        raise DecodeError(f"role: {role!r:.40} is neither target nor anchor")
    return Candidate(
        instance_id=integer(wire.get("id"), "id"),
        role=role,
        words=text_of(wire, "words"),
        label=text_of(wire, "label"),
        p=probability(wire.get("p"), "p"),
        cosine=number(wire.get("cosine"), "cosine"),
        centre_world=numbers(wire, "centre_world", (3,)),
        T_world_box=numbers(wire, "T_world_box", (4, 4)),
        box_size_m=numbers(wire, "box_size_m", (3,)),
        views=tuple(list_of(wire, "views", MAX_VIEWS, _view)),
        supported_by=integer(wire.get("supported_by"), "supported_by"),
        inside=integer(wire.get("inside"), "inside"),
        neighbours=tuple(list_of(wire, "neighbours", MAX_NEIGHBOURS, _neighbour)),
    )


def _neighbour(wire: Any) -> int:
    return integer(wire, "neighbours")


def _view(wire: Any) -> tuple[int, Box]:
    if not isinstance(wire, list) or len(wire) != 5:
        raise DecodeError("views: expected [seq, left, top, right, bottom]")
    left, top, right, bottom = (number(value, "views") for value in wire[1:])
    return integer(wire[0], "views"), (left, top, right, bottom)


def _named(wire: Any) -> tuple[str, float]:
    if not isinstance(wire, list) or len(wire) != 2 or not isinstance(wire[0], str):
        raise DecodeError("expected [label, p]")
    return wire[0][:MAX_TEXT], probability(wire[1], "labels")


def _ranked(wire: Any) -> tuple[int, float]:
    if not isinstance(wire, list) or len(wire) != 2:
        raise DecodeError("ranking: expected [id, p]")
    return integer(wire[0], "ranking"), probability(wire[1], "ranking")
