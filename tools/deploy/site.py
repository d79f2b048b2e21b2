"""What every machine of a graph runs, ready to be written in whatever form its owner starts it."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

from sceneq_nodes._credentials import tls_link
from sceneq_nodes._session import client_config, router_config
from sceneq_tools.endpoint import host_and_port
from sceneq_tools.graph import Graph, GraphNode
from sceneq_tools.graph_document import Document
from sceneq_tools.graph_machines import machine_names
from sceneq_tools.graph_plan import Plan, plan
from sceneq_tools.supervision import BUS_LOG
from sceneq_tools.threads import ONE_THREAD

GRAPH_FILE = "graph.json"
STORE = PurePosixPath("/var/lib/sceneq")
CONFIG = PurePosixPath("/etc/sceneq")
NODE_ROLE, ROUTER_ROLE = "node", "router"
LOOPBACK = ("127.", "localhost", "[::1]")


@dataclass(frozen=True, slots=True)
class Site:
    """One machine: its part of the graph, and whether its links are encrypted.

    ``plan`` holds no secret: where credentials lie is told to each process in its environment.
    """

    machine: str
    plan: Plan
    encrypted: bool

    def graph_json(self) -> str:
        """Return what the processes read: ``SCENEQ_GRAPH``."""
        return json.dumps(self.plan.as_json(), indent=2) + "\n"

    def environment(self, node: str) -> dict[str, str]:
        """Return the environment of a process, credentials not included."""
        name = {"SCENEQ_NODE": node}
        return {"SCENEQ_GRAPH": str(CONFIG / GRAPH_FILE), **name, **ONE_THREAD, **BUS_LOG}

    def ports(self) -> list[int]:
        """Return the ports that other machines reach the router at."""
        addresses = map(host_and_port, self.plan.router.listen)
        return [int(port) for host, port in addresses if not _is_local(host)]

    def folders(self, node: GraphNode) -> list[str]:
        """Return the absolute paths a node reads from, as its parameters name them."""
        return sorted(set(_values(node.params, "path", is_path=True)))

    def keys(self, node: GraphNode) -> list[str]:
        """Return the names of environment variables that hold secrets of other services."""
        return sorted(set(_values(node.params, "key_env", is_path=False)))

    def zenoh_files(self) -> dict[str, str]:
        """Return zenoh's own configuration of router and nodes, for zenohd and for other tools."""
        router = router_config(self.plan.router.listen, self.plan.router.connect)
        node = client_config(self.plan.endpoint, None)
        if self.encrypted:
            for config, role in ((router, ROUTER_ROLE), (node, NODE_ROLE)):
                tls = tls_link(Path(CONFIG / "credentials" / role))
                config["transport"]["link"] = {
                    **config["transport"]["link"],
                    "protocols": ["tls", "quic"],
                    "tls": tls,
                }
        return {
            "router.json5": _json5(ROUTER_WORDS, router),
            "node.json5": _json5(NODE_WORDS, node),
        }


ROUTER_WORDS = """\
// The router as `python -m sceneq_nodes router` configures it from graph.json; zenohd -c takes it
// too. Who may do what is not here: it stands in access.json beside the router's certificate.
"""
NODE_WORDS = """\
// How a node or client of this machine reaches its router.
"""


def sites(graph: Graph, document: Document) -> list[Site]:
    """Return one site for each machine that runs something.

    Raises:
        UserError: no scene, or an endpoint that is not encrypted where all must be.
    """
    found = []
    for machine in machine_names(graph):
        planned = plan(graph, document, machine, elsewhere=True)
        store = None if graph.store is None else Path(STORE)
        local = replace(planned, store=store, secure=None)
        found.append(Site(machine, local, graph.secure is not None))
    return found


def _json5(words: str, config: Mapping[str, Any]) -> str:
    return words + json.dumps(config, indent=2) + "\n"


def _is_local(host: str) -> bool:
    return host.startswith(LOOPBACK)


def _values(params: Any, name: str, is_path: bool) -> Iterator[str]:
    """Yield the texts under the key ``name`` at any depth; of paths the absolute ones."""
    if isinstance(params, Mapping):
        for key, value in params.items():
            if key == name and isinstance(value, str) and value:
                if not is_path or value.startswith("/"):
                    yield value
            else:
                yield from _values(value, name, is_path)
