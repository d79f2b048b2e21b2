"""A mapper taken apart, and one that goes on where another stopped."""

from collections.abc import Mapping
from typing import Any

from sceneq_core.mapping.mapper import Mapper, MapperParams
from sceneq_core.state import State, StateError, build, fields_of_classes, take_apart


def state_of(mapper: Mapper, beside: Mapping[str, Any]) -> State:
    """Return everything that decides what ``mapper`` does next, and what its owner keeps beside.

    ``beside``: names -> plain values, arrays, bytes, and lists, tuples and dicts of them.
    """
    return take_apart((mapper, dict(beside)))


def resumed(state: State, params: MapperParams) -> tuple[Mapper, dict[str, Any]]:
    """Return a mapper that does what the one would have done next, and what was kept beside.

    Raises:
        StateError: ``state`` is no mapper's, that of another version of the code, or its
            parameters were others.
    """
    _check_fields(state, take_apart(Mapper(params)))
    root = build(state)
    match root:
        case (Mapper() as mapper, dict() as beside):
            if mapper.params != params:
                raise StateError("the map was made with other parameters")
            return mapper, beside
    raise StateError(f"no mapper but a {type(root).__name__}")


def _check_fields(state: State, present: State) -> None:
    """Refuse objects that lack what this version of their class has, or know more."""
    now = fields_of_classes(present)
    for name, names in fields_of_classes(state).items():
        if differing := names ^ now.get(name, names):
            raise StateError(f"{name} differs in {', '.join(sorted(differing))}")
