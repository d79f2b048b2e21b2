"""A constraint of a question as it travels: relation and anchor, and what else it says."""

from dataclasses import fields
from typing import Any

from sceneq_core.reasoning.reasoner import Constraint
from sceneq_nodes._json_fields import MAX_TEXT
from sceneq_schemas.errors import DecodeError

MAX_RANK = 50

_DEFAULTS = {one.name: one.default for one in fields(Constraint)[2:]}


def constraint_json(constraint: Constraint) -> list[Any]:
    """Return ``[relation, anchor]``, and an object with what is not as usual."""
    more = {name: getattr(constraint, name) for name in _DEFAULTS}
    unusual = {name: value for name, value in more.items() if value != _DEFAULTS[name]}
    plain = [constraint.relation, constraint.anchor]
    return [*plain, unusual] if unusual else plain


def constraint_from_json(wire: Any) -> Constraint:
    """Return the constraint; raise ``DecodeError`` when it is none."""
    if not isinstance(wire, list) or [type(part) for part in wire[:2]] != [str, str]:
        raise DecodeError("constraints: expected [relation, anchor]")
    more = wire[2] if len(wire) == 3 else {}
    if len(wire) > 3 or not isinstance(more, dict):
        raise DecodeError("constraints: expected [relation, anchor, {...}]")
    for name, value in more.items():
        if name not in _DEFAULTS or type(value) is not type(_DEFAULTS[name]):
            raise DecodeError(f"constraints: cannot use {name!r:.40}")
    if not 1 <= more.get("rank", 1) <= MAX_RANK:
        raise DecodeError(f"constraints: rank is not in 1..{MAX_RANK}")
    texts = (part[:MAX_TEXT] for part in wire[:2])
    return Constraint(*texts, **{name: _short(value) for name, value in more.items()})


def _short(value: Any) -> Any:
    return value[:MAX_TEXT] if isinstance(value, str) else value
