"""Check every node of a graph against the class it names, without starting anything."""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import is_dataclass
from functools import partial
from typing import Any, get_type_hints

from sceneq_nodes._backends import BACKENDS, load
from sceneq_nodes._backends import check as check_backend
from sceneq_nodes._params import ParamError, validate
from sceneq_tools.graph import Graph, GraphNode, shown_path
from sceneq_tools.graph_document import Document, KeyPath
from sceneq_tools.graph_machines import machine_problems
from sceneq_tools.graph_problem import ABSENT, GraphError, Problem
from sceneq_tools.graph_robots import robot_problems

MISSING = "missing key"
OWN_CHECK = re.compile(r"Value error, (?:(?P<field>\w+): )?(?P<text>.*)", re.DOTALL)
"""How pydantic tells what ``__post_init__`` said; ours name the field and the value."""
SEAMS = {name: name for name in BACKENDS if name != "nodes"} | {"meanwhile": "encoder"}
"""Parameter -> the seam whose ``{kind: ...}`` it holds."""


def check_nodes(graph: Graph, document: Document) -> None:
    """Raise ``GraphError`` with everything that is wrong: machines, robots, kinds, parameters."""
    problems = [*machine_problems(graph, document), *robot_problems(graph, document)]
    problems += [
        _problem(document, error)
        for index, node in enumerate(graph.nodes)
        for error in _node_errors(node, ("nodes", index))
    ]
    if problems:
        raise GraphError(problems)


def _node_errors(node: GraphNode, path: KeyPath) -> Iterator[ParamError]:
    try:
        params_class = load("nodes", node.node_kind, path).Params
    except ParamError as error:
        yield error
        return
    yield from _params_errors(params_class, node.params, (*path, "params"))


def _params_errors(
    params_class: type[Any], params: Mapping[str, Any], path: KeyPath
) -> Iterator[ParamError]:
    """Yield every error, not just the first: a bad key is reported, then left out."""
    told = set()
    for name, value in params.items():
        for error in _inner_errors(params_class, name, value, (*path, name)):
            told.add(name)
            yield error
    rest = {name: value for name, value in params.items() if name not in told}
    yield from _errors(partial(validate, params_class, path=path), rest, path, told)


def _inner_errors(
    params_class: type[Any], name: str, value: Any, path: KeyPath
) -> Iterator[ParamError]:
    """Yield the errors inside a backend's ``{kind: ...}`` or a group of parameters."""
    if not isinstance(value, Mapping):
        return
    group = get_type_hints(params_class).get(name)
    if name in SEAMS:
        yield from _errors(partial(check_backend, SEAMS[name], path=path), value, path, set())
    elif isinstance(group, type) and is_dataclass(group):
        yield from _params_errors(group, value, path)


def _errors(
    validation: Callable[[Mapping[str, Any]], object],
    params: Mapping[str, Any],
    path: KeyPath,
    told: set[str],
) -> Iterator[ParamError]:
    values, left_out = dict(params), set(told)
    while True:
        try:
            validation(values)
            return
        except ParamError as error:
            key = str(error.path[len(path)]) if len(error.path) > len(path) else ""
            if key not in left_out:
                yield error
            if key not in values:
                return
            left_out.add(key)
            del values[key]


def _problem(document: Document, error: ParamError) -> Problem:
    path, message, value = error.path, error.message, error.value
    if found := OWN_CHECK.fullmatch(message):
        path, message, value = (*path, *filter(None, [found["field"]])), found["text"], ABSENT
    elif message in (MISSING, "unknown key"):
        value = ABSENT
    return Problem(document.where(path), shown_path(document, path), message, value, error.hint)
