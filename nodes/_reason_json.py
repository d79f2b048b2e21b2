"""Problems and verdicts as they travel between routing and reasoning: JSON, checked and bounded."""

import json
import math
import sys
from collections.abc import Callable
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.reasoning.reasoner import (
    NO_USAGE,
    Box,
    Candidate,
    Constraint,
    LabelProblem,
    LabelVerdict,
    Problem,
    UnansweredError,
    Usage,
    Verdict,
    Views,
)
from sceneq_nodes._wire import json_bytes
from sceneq_schemas.errors import DecodeError

MAX_CANDIDATES = 256
MAX_CONSTRAINTS = 8
MAX_VIEWS = 16
MAX_NEIGHBOURS = 4096
MAX_TEXT = 1000


def problem_bytes(problem: Problem) -> bytes:
    """Return the JSON of a problem."""
    return json_bytes(
        {
            "text": problem.text,
            "target": problem.target,
            "constraints": [[c.relation, c.anchor] for c in problem.constraints],
            "candidates": [_candidate_json(c) for c in problem.candidates],
            "up_world": problem.up_world.tolist(),
            "viewpoint_world": problem.viewpoint_world.tolist(),
            "time_s": _time_json(problem.time_s),
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
        }
    )


def any_problem_from_bytes(data: bytes) -> Problem | LabelProblem:
    """Return the problem in ``data``, of either direction; raise ``DecodeError``."""
    wire = _object(_parse(data), "problem")
    if "label_of" not in wire:
        return _problem(wire)
    return LabelProblem(
        instance_id=_integer(wire["label_of"], "label_of"),
        labels=tuple(_list(wire, "labels", MAX_CANDIDATES, _named)),
        views=tuple(_list(wire, "views", MAX_VIEWS, _view)),
        time_s=_time_s(wire),
    )


def problem_from_bytes(data: bytes) -> Problem:
    """Return the problem in ``data``; raise ``DecodeError`` naming what is wrong with it."""
    return _problem(_object(_parse(data), "problem"))


def _problem(wire: dict[str, Any]) -> Problem:
    return Problem(
        text=_text(wire, "text"),
        target=_text(wire, "target"),
        constraints=tuple(_list(wire, "constraints", MAX_CONSTRAINTS, _constraint)),
        candidates=tuple(_list(wire, "candidates", MAX_CANDIDATES, _candidate)),
        up_world=_unit(_numbers(wire, "up_world", (3,))),
        viewpoint_world=_numbers(wire, "viewpoint_world", (3,)),
        time_s=_time_s(wire),
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
    return Verdict(tuple(_list(wire, "ranking", MAX_CANDIDATES, _ranked)), *_reason_and_cost(wire))


def label_verdict_from_bytes(data: bytes) -> LabelVerdict:
    """Return what the instance is called; raises as ``verdict_from_bytes``."""
    wire = _answered(data)
    ranking = tuple(_list(wire, "ranking", MAX_CANDIDATES, _named))
    return LabelVerdict(ranking, *_reason_and_cost(wire))


def _answered(data: bytes) -> dict[str, Any]:
    wire = _object(_parse(data), "verdict")
    if "unanswered" in wire:
        calls, usage = _cost(wire)
        raise UnansweredError(_text(wire, "unanswered"), calls, usage)
    return wire


def _reason_and_cost(wire: dict[str, Any]) -> tuple[str, int, Usage]:
    return (_text(wire, "reason"), *_cost(wire))


def _cost(wire: dict[str, Any]) -> tuple[int, Usage]:
    return _integer(wire.get("vlm_calls"), "vlm_calls"), _usage(wire.get("usage"))


def _usage_json(usage: Usage) -> list[float]:
    return [usage.tokens_in, usage.tokens_out, usage.money]


def _usage(wire: Any) -> Usage:
    """A reasoner that uses no model may leave it out."""
    if wire is None:
        return NO_USAGE
    if not isinstance(wire, list) or len(wire) != 3:
        raise DecodeError("usage: expected [tokens_in, tokens_out, money]")
    tokens_in, tokens_out = (_integer(value, "usage") for value in wire[:2])
    return Usage(tokens_in, tokens_out, _number(wire[2], "usage"))


def _time_json(time_s: float) -> float | None:
    return time_s if math.isfinite(time_s) else None


def _time_s(wire: dict[str, Any]) -> float:
    value = wire.get("time_s")
    return math.inf if value is None else max(0.0, _number(value, "time_s"))


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
    wire = _object(wire, "candidate")
    role = _text(wire, "role")
    if role not in ("target", "anchor"):
        raise DecodeError(f"role: {role!r:.40} is neither target nor anchor")
    return Candidate(
        instance_id=_integer(wire.get("id"), "id"),
        role=role,
        words=_text(wire, "words"),
        label=_text(wire, "label"),
        p=_probability(wire.get("p"), "p"),
        cosine=_number(wire.get("cosine"), "cosine"),
        centre_world=_numbers(wire, "centre_world", (3,)),
        T_world_box=_numbers(wire, "T_world_box", (4, 4)),
        box_size_m=_numbers(wire, "box_size_m", (3,)),
        views=tuple(_list(wire, "views", MAX_VIEWS, _view)),
        supported_by=_integer(wire.get("supported_by"), "supported_by"),
        inside=_integer(wire.get("inside"), "inside"),
        neighbours=tuple(_list(wire, "neighbours", MAX_NEIGHBOURS, _neighbour)),
    )


def _neighbour(wire: Any) -> int:
    return _integer(wire, "neighbours")


def _view(wire: Any) -> tuple[int, Box]:
    if not isinstance(wire, list) or len(wire) != 5:
        raise DecodeError("views: expected [seq, left, top, right, bottom]")
    left, top, right, bottom = (_number(value, "views") for value in wire[1:])
    return _integer(wire[0], "views"), (left, top, right, bottom)


def _constraint(wire: Any) -> Constraint:
    if not isinstance(wire, list) or [type(part) for part in wire] != [str, str]:
        raise DecodeError("constraints: expected [relation, anchor]")
    return Constraint(*(part[:MAX_TEXT] for part in wire))


def _named(wire: Any) -> tuple[str, float]:
    if not isinstance(wire, list) or len(wire) != 2 or not isinstance(wire[0], str):
        raise DecodeError("expected [label, p]")
    return wire[0][:MAX_TEXT], _probability(wire[1], "labels")


def _ranked(wire: Any) -> tuple[int, float]:
    if not isinstance(wire, list) or len(wire) != 2:
        raise DecodeError("ranking: expected [id, p]")
    return _integer(wire[0], "ranking"), _probability(wire[1], "ranking")


def _parse(data: bytes) -> Any:
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise DecodeError(f"not JSON: {error}") from error


def _object(wire: Any, what: str) -> dict[str, Any]:
    if not isinstance(wire, dict):
        raise DecodeError(f"{what}: expected an object, got {type(wire).__name__}")
    return wire


def _list(wire: dict[str, Any], name: str, limit: int, convert: Callable[[Any], Any]) -> list[Any]:
    value = wire.get(name)
    if not isinstance(value, list) or len(value) > limit:
        raise DecodeError(f"{name}: expected a list of at most {limit}")
    return [convert(item) for item in value]


def _text(wire: dict[str, Any], name: str) -> str:
    value = wire.get(name)
    if not isinstance(value, str) or len(value) > MAX_TEXT:
        raise DecodeError(f"{name}: expected a text of at most {MAX_TEXT} characters")
    return value


def _integer(value: Any, name: str) -> int:
    if type(value) is not int or not -(2**63) <= value < 2**63:
        raise DecodeError(f"{name}: expected an integer, got {value!r:.40}")
    return value


def _number(value: Any, name: str) -> float:
    if type(value) not in (int, float) or not abs(value) <= sys.float_info.max:
        raise DecodeError(f"{name}: expected a finite number, got {value!r:.40}")
    return float(value)


def _probability(value: Any, name: str) -> float:
    p = _number(value, name)
    if not 0.0 <= p <= 1.0:
        raise DecodeError(f"{name}: {p} is not a probability")
    return p


def _numbers(wire: dict[str, Any], name: str, shape: tuple[int, ...]) -> Float64:
    try:
        array = np.array(wire.get(name), np.float64)
    except (ValueError, TypeError, OverflowError) as error:
        raise DecodeError(f"{name}: expected numbers: {error}") from error
    if array.shape != shape or not np.isfinite(array).all():
        raise DecodeError(f"{name}: expected {shape} finite numbers, got shape {array.shape}")
    return array


def _unit(vector: Float64) -> Float64:
    largest = np.abs(vector).max()
    if not largest > 0:
        raise DecodeError("up_world: has no length")
    scaled = vector / largest
    unit: Float64 = scaled / np.linalg.norm(scaled)
    return unit
