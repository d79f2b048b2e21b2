"""Check every node of a graph against the class it names, without starting anything."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

from sceneq_nodes._backends import BACKENDS, load
from sceneq_nodes._backends import check as check_backend
from sceneq_nodes._params import ParamError, validate
from sceneq_tools.graph import Graph, GraphNode, shown_path
from sceneq_tools.graph_document import Document, KeyPath
from sceneq_tools.graph_problem import ABSENT, GraphError, Problem

MISSING = "missing key"
SEAMS = BACKENDS.keys() - {"nodes"}


def check_nodes(graph: Graph, document: Document) -> None:
    """Raise ``GraphError`` with everything that is wrong with the nodes' kinds and parameters."""
    problems = [
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
    backends = {k: v for k, v in params.items() if k in SEAMS and isinstance(v, Mapping)}
    yield from _errors(partial(validate, params_class, path=path), params, path)
    for seam, spec in backends.items():
        here = (*path, seam)
        yield from _errors(partial(check_backend, seam, path=here), spec, here)


def _errors(
    validation: Callable[[Mapping[str, Any]], object], params: Mapping[str, Any], path: KeyPath
) -> Iterator[ParamError]:
    values, left_out = dict(params), set()
    while True:
        try:
            validation(values)
            return
        except ParamError as error:
            key = error.path[len(path)] if len(error.path) > len(path) else None
            if key not in left_out:
                yield error
            if key not in values:
                return
            left_out.add(key)
            del values[str(key)]


def _problem(document: Document, error: ParamError) -> Problem:
    path = error.path
    value = ABSENT if error.message in (MISSING, "unknown key") else error.value
    return Problem(
        document.where(path), shown_path(document, path), error.message, value, error.hint
    )
