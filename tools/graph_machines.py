"""The machines of a graph: which nodes each runs, and how their routers find each other."""

import re
from collections.abc import Iterator, Sequence

from sceneq_nodes._params import did_you_mean
from sceneq_tools.crossing import overloads
from sceneq_tools.endpoint import bare
from sceneq_tools.graph import Graph, Router, shown_path
from sceneq_tools.graph_document import Document, KeyPath
from sceneq_tools.graph_problem import Problem

PRIO = re.compile(r"prio=(?P<first>[0-7])-(?P<last>[0-7])")
PRIORITIES = range(8)


def router_of(graph: Graph, machine: str) -> Router:
    """Return the router of ``machine``: its own, else the one for all."""
    own = graph.machines.get(machine)
    if own is not None and "router" in own.model_fields_set:
        return own.router
    return graph.router


def machine_names(graph: Graph) -> list[str]:
    """Return the machines of a graph, those without nodes too, in the order of the file."""
    deployed = [node.deploy.machine for node in graph.nodes]
    return list(dict.fromkeys([*graph.machines, *deployed]))


def machine_problems(graph: Graph, document: Document) -> list[Problem]:
    """Return what is wrong: nodes on no machine, links that leave a gap or carry too much, a scene
    that nobody names.
    """
    homeless, gaps = _homeless(graph, document), _gaps(graph, document)
    return [*homeless, *gaps, *_nameless(graph, document), *_too_thin(graph, document)]


def _homeless(graph: Graph, document: Document) -> Iterator[Problem]:
    for index, node in enumerate(graph.nodes):
        machine = node.deploy.machine
        if graph.machines and machine not in graph.machines:
            path: KeyPath = ("nodes", index, "deploy", "machine")
            hint = did_you_mean(machine, graph.machines)
            message = "not one of 'machines'"
            yield Problem(document.where(path), shown_path(document, path), message, machine, hint)


def _gaps(graph: Graph, document: Document) -> Iterator[Problem]:
    routers: list[tuple[KeyPath, Router]] = [(("router",), graph.router)]
    routers += [(("machines", name, "router"), one.router) for name, one in graph.machines.items()]
    for path, router in routers:
        where = (*path, "connect")
        for message in link_problems(router.connect):
            yield Problem(document.where(where), shown_path(document, where), message)


def _nameless(graph: Graph, document: Document) -> Iterator[Problem]:
    """A scene is called after the source's folder, which only one of the machines may have."""
    if len({node.deploy.machine for node in graph.nodes}) > 1 and graph.scene is None:
        hint = "add 'scene: NAME': all machines must use the same"
        yield Problem(document.where(("scene",)), "scene", "missing key", hint=hint)


def _too_thin(graph: Graph, document: Document) -> Iterator[Problem]:
    for machine, message in overloads(graph):
        path: KeyPath = ("machines", machine, "uplink_mbit_s")
        limit = graph.machines[machine].uplink_mbit_s
        hint = "jpeg and delta as codecs of ingest, fewer keyframes, 'pull' of a mirror"
        yield Problem(document.where(path), shown_path(document, path), message, limit, hint)


def link_problems(endpoints: Sequence[str]) -> list[str]:
    """Return why links would not carry every priority of messages once.

    ``tcp/HOST:7448?prio=0-3`` and ``tcp/HOST:7449?prio=4-7`` make two links of the connection to
    one host: frames that wait in one do not hold up the questions in the other. Zenoh's
    priorities: 1 to 3 are for questions, 4 for state, 5 to 7 for frames and what else is large.
    """
    by_host: dict[str, list[str]] = {}
    for endpoint in endpoints:
        metadata = endpoint.partition("#")[0].partition("?")[2]
        by_host.setdefault(bare(endpoint).rpartition(":")[0], []).append(metadata)
    problems = []
    for host, links in by_host.items():
        ranges = [PRIO.fullmatch(link) for link in links if link]
        if not ranges:
            continue
        carried = [p for r in ranges if r for p in range(int(r["first"]), int(r["last"]) + 1)]
        if len(ranges) != len(links) or None in ranges or sorted(carried) != list(PRIORITIES):
            problems.append(
                f"the links to {host.partition('/')[2]} must carry priorities 0 to 7 once: "
                "such as ?prio=0-3 and ?prio=4-7"
            )
    return problems
