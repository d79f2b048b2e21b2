"""What one process is to run: from the launcher's graph file, or from the command line alone."""

import argparse
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sceneq_nodes._bus import Context
from sceneq_nodes._credentials import Credentials, given_credentials
from sceneq_nodes._params import ParamError, did_you_mean
from sceneq_schemas.topics import ID

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
ROUTER = "router"


@dataclass(frozen=True, slots=True)
class Launch:
    """One node of a graph, parameters not validated yet."""

    kind: str
    context: Context
    params: Mapping[str, Any]
    endpoint: str


@dataclass(frozen=True, slots=True)
class RouterLaunch:
    """A machine's router: where it listens, which others it joins, and how it proves itself."""

    listen: Sequence[str]
    connect: Sequence[str]
    credentials: Credentials | None = None
    scene: str = ""


def read_launch(
    arguments: Sequence[str], environment: Mapping[str, str] = os.environ
) -> Launch | RouterLaunch:
    """Return what to run.

    ``SCENEQ_GRAPH`` names the JSON file that the launcher wrote and ``SCENEQ_NODE`` the node in
    it. Without them ``python -m sceneq_nodes KIND --scene NAME --param key=value`` runs one alone.

    Raises:
        ValueError: no such file or node, a name that cannot be part of a key, or a parameter
            that is not ``key=value``.
    """
    options = _options(arguments)
    graph = _graph(environment.get("SCENEQ_GRAPH"))
    if options.kind == ROUTER:
        router = graph.get("router", {})
        listen = [options.endpoint] if options.endpoint else router.get("listen")
        folder = router.get("credentials")
        credentials = Credentials(Path(folder)) if folder else given_credentials(environment)
        listen, connect = listen or [DEFAULT_ENDPOINT], router.get("connect", ())
        return RouterLaunch(listen, connect, credentials, graph.get("scene", ""))
    name = options.node or environment.get("SCENEQ_NODE") or options.kind
    if not name:
        raise ValueError("nothing to run: name a node kind, or set SCENEQ_GRAPH and SCENEQ_NODE")
    node = _node(graph, name) if graph else {"kind": options.kind or name, "params": {}}
    scene = options.scene or graph.get("scene", "scene")
    store = options.store or graph.get("store")
    context = Context(
        node=name,
        scene=scene,
        robot=options.robot or graph.get("robot", "robot"),
        sensor=options.sensor or graph.get("sensor", "camera"),
        store=Path(store) / scene if store else None,
    )
    _need_ids(context)
    endpoint = options.endpoint or graph.get("router", {}).get("endpoint", DEFAULT_ENDPOINT)
    return Launch(node["kind"], context, _with(node.get("params", {}), options.param), endpoint)


def _need_ids(context: Context) -> None:
    for name in ("node", "scene", "robot", "sensor"):
        if not ID.fullmatch(value := getattr(context, name)):
            raise ParamError((name,), value, f"{value!r} does not match {ID.pattern}", "")


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m sceneq_nodes", description=__doc__)
    parser.add_argument("kind", nargs="?", help=f"kind of node, or '{ROUTER}'")
    parser.add_argument("--param", action="append", default=[], metavar="KEY=VALUE")
    for name in ("node", "scene", "robot", "sensor", "endpoint", "store"):
        parser.add_argument(f"--{name}")
    return parser.parse_args(arguments)


def _graph(path: str | None) -> dict[str, Any]:
    if not path:
        return {}
    try:
        graph: dict[str, Any] = json.loads(Path(path).read_text())
    except (OSError, ValueError) as error:
        raise ValueError(f"SCENEQ_GRAPH {path}: {error}") from error
    return graph


def _node(graph: Mapping[str, Any], name: str) -> dict[str, Any]:
    nodes: dict[str, dict[str, Any]] = graph.get("nodes", {})
    if name not in nodes:
        raise ParamError(("nodes", name), name, "no such node", did_you_mean(name, nodes))
    return nodes[name]


def _with(params: Mapping[str, Any], texts: Sequence[str]) -> dict[str, Any]:
    """Return ``params`` with each ``a.b=value`` set; a value is JSON, or else a string."""
    merged: dict[str, Any] = json.loads(json.dumps(dict(params)))
    for text in texts:
        path, equals, value = text.partition("=")
        if not equals or not path:
            raise ValueError(f"--param {text}: expected KEY=VALUE")
        *parents, last = path.split(".")
        place = merged
        for parent in parents:
            place = place.setdefault(parent, {})
        place[last] = _value(value)
    return merged


def _value(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return text
