"""The ROS 2 keys that a graph names, and whether the rules of a router let them pass."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from sceneq_nodes._backends import load as load_backend
from sceneq_nodes._params import ParamError, validate
from sceneq_nodes.ros.passage import RosKeys, output_keys, source_keys
from sceneq_tools.errors import UserError
from sceneq_tools.graph import load

INGEST, ROS, ROS2 = "ingest", "ros", "ros2"


def keys_in_graph(path: Path) -> RosKeys:
    """Return the keys of a graph file; ``UserError`` when it cannot be read."""
    graph, _ = load(path)
    try:
        return keys_of((node.node_kind, node.params) for node in graph.nodes)
    except ParamError as error:
        raise UserError(f"{path}: {error}", 2) from error


def keys_of(nodes: Iterable[tuple[str, Mapping[str, Any]]]) -> RosKeys:
    """Return the keys of nodes, each a kind and its parameters; ``ParamError`` on wrong ones."""
    keys = RosKeys()
    for kind, params in nodes:
        source = dict(params.get("source", {}))
        if kind == INGEST and source.pop("kind", "") == ROS2:
            keys |= source_keys(_checked("source", ROS2, source))
        elif kind == ROS:
            keys |= output_keys(_checked("nodes", ROS, params))
    return keys


def denied(access: Mapping[str, Any], keys: RosKeys) -> list[str]:
    """Return which of the keys no rule names."""
    named = {key for rule in access["rules"] for key in rule["key_exprs"]}
    return [key for key in (*keys.read, *keys.written) if key not in named]


def _checked(seam: str, kind: str, params: Mapping[str, Any]) -> Any:
    return validate(load_backend(seam, kind).Params, params, (kind,))
