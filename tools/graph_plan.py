"""What one machine runs: the graph after scene, machine and endpoints are settled."""

import re
import socket
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sceneq_nodes._credentials import SECURE
from sceneq_nodes._logs import TEXT
from sceneq_nodes._params import did_you_mean
from sceneq_tools.endpoint import host_and_port
from sceneq_tools.errors import UserError
from sceneq_tools.graph import DEFAULT_ENDPOINT, ROUTER, Graph, GraphNode, Router, WatchdogLimits
from sceneq_tools.graph_document import Document
from sceneq_tools.graph_machines import machine_names, router_of
from sceneq_tools.graph_problem import GraphError, Problem

DEFAULT_SECURE = DEFAULT_ENDPOINT.replace("tcp/", "tls/")
ANYWHERE = {"0.0.0.0": "127.0.0.1", "[::]": "[::1]"}
"""Listening on every address is reached, from this machine, on the loopback one."""


@dataclass(frozen=True, slots=True)
class Plan:
    """The local part of a graph, ready to start."""

    scene: str
    robot: str
    sensor: str
    router: Router
    watchdog: WatchdogLimits
    nodes: tuple[GraphNode, ...]
    store: Path | None = None
    secure: Path | None = None
    log: str = TEXT

    @property
    def endpoint(self) -> str:
        """Where nodes and clients of this machine reach the router."""
        first = self.router.listen[0]
        protocol, (host, port) = first.partition("/")[0], host_and_port(first)
        return f"{protocol}/{ANYWHERE.get(host, host)}:{port}"

    def as_json(self) -> dict[str, Any]:
        """Return what every node reads from the file that ``SCENEQ_GRAPH`` names."""
        return {
            "scene": self.scene,
            "robot": self.robot,
            "sensor": self.sensor,
            "store": None if self.store is None else str(self.store),
            "router": {
                "endpoint": self.endpoint,
                "credentials": None if self.secure is None else str(self.secure / ROUTER),
                **self.router.model_dump(),
            },
            "nodes": {n.id: {"kind": n.node_kind, "params": n.params} for n in self.nodes},
        }


def plan(
    graph: Graph,
    document: Document,
    machine: str,
    only: Collection[str] = (),
    port: int | None = None,
    connect: Sequence[str] = (),
    elsewhere: bool = False,
) -> Plan:
    """Return what ``machine`` runs, or those of its nodes that ``only`` names.

    ``port`` replaces the one the router listens on, ``connect`` the routers it joins;
    ``elsewhere``: it is another machine, whose folders are not to be found here.

    Raises:
        UserError: nothing runs there, an unknown name, no scene, or no such source folder.
    """
    nodes = _chosen(_on(machine, graph), only)
    if not elsewhere:
        _need_sources(nodes, graph, document)
    secure = None if graph.secure is None else Path(graph.secure).expanduser().resolve()
    router = router_of(graph, machine)
    if connect:
        router = router.model_copy(update={"connect": list(connect)})
    router = router if secure is None else encrypted(router)
    return Plan(
        graph.scene or _scene_of(graph, document),
        graph.robot,
        graph.sensor,
        router if port is None else _on_port(router, port),
        graph.watchdog,
        nodes,
        None if graph.store is None else Path(graph.store).expanduser().resolve(),
        secure,
        graph.log,
    )


def encrypted(router: Router) -> Router:
    """Return the router with encrypted links only: the endpoint by default is, then, TLS.

    Raises:
        UserError: an endpoint of another protocol.
    """
    listen = [DEFAULT_SECURE if one == DEFAULT_ENDPOINT else one for one in router.listen]
    for endpoint in (*listen, *router.connect):
        if not endpoint.startswith(SECURE):
            raise UserError(f"{endpoint}: not encrypted; with 'secure' say tls/HOST:PORT", 2)
    return router.model_copy(update={"listen": listen})


def scene_name(source: Path) -> str:
    """Return the name of a folder or file as an id: ``My Kitchen 2.bag`` -> ``my_kitchen_2``."""
    path = source.resolve()
    name = path.stem if path.is_file() else path.name
    return re.sub(r"[^a-z0-9_-]+", "_", name.lower()).strip("_") or "scene"


def need_free_port(endpoint: str) -> None:
    """Raise ``UserError`` when somebody else listens on a TCP ``endpoint``."""
    protocol, (host, port) = endpoint.partition("/")[0], host_and_port(endpoint)
    if protocol not in ("tcp", "tls"):
        return
    family = socket.AF_INET6 if host.startswith("[") else socket.AF_INET
    with socket.socket(family) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host.strip("[]"), int(port)))
        except (OSError, ValueError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            hint = "another graph runs here? take another port: sceneq up --port N"
            raise UserError(f"cannot listen on {endpoint}: {reason.lower()} ({hint})") from error


def _on_port(router: Router, port: int) -> Router:
    first, *others = router.listen
    host, _, _ = first.rpartition(":")
    return router.model_copy(update={"listen": [f"{host}:{port}", *others]})


def _on(machine: str, graph: Graph) -> list[GraphNode]:
    nodes = [node for node in graph.nodes if node.deploy.machine == machine]
    if not nodes and machine not in graph.machines:
        hint = did_you_mean(machine, set(machine_names(graph)))
        raise UserError(f"no node has 'deploy: {{machine: {machine}}}' ({hint})", 2)
    return nodes


def _chosen(nodes: list[GraphNode], only: Collection[str]) -> tuple[GraphNode, ...]:
    known = {node.id for node in nodes}
    for name in only:
        if name not in known | {ROUTER}:
            raise UserError(f"--only {name}: no such node here ({did_you_mean(name, known)})", 2)
    return tuple(node for node in nodes if not only or node.id in only)


def _need_sources(nodes: Collection[GraphNode], graph: Graph, document: Document) -> None:
    for index, node in enumerate(graph.nodes):
        path = ("nodes", index, "params", "source", "path")
        folder = _source(node)
        if node in nodes and folder is not None and not folder.exists():
            where, shown = document.where(path), f"nodes.{node.id}.params.source.path"
            hint = "say which with --source FOLDER"
            raise GraphError([Problem(where, shown, "no such folder", str(folder), hint)])


def _scene_of(graph: Graph, document: Document) -> str:
    for node in graph.nodes:
        if (folder := _source(node)) is not None:
            return scene_name(folder)
    hint = "add 'scene: NAME' or say --scene NAME"
    raise GraphError([Problem(document.where(("scene",)), "scene", "missing key", hint=hint)])


def _source(node: GraphNode) -> Path | None:
    source = node.params.get("source")
    path = source.get("path") if isinstance(source, dict) else None
    return Path(path) if isinstance(path, str) else None
