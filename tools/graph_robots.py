"""The robots of a graph: whose frames an ingest sends, others have to be told to hear."""

from collections.abc import Iterator

from sceneq_nodes._backends import load
from sceneq_nodes._params import ParamError
from sceneq_tools.graph import Graph, GraphNode, shown_path
from sceneq_tools.graph_document import Document, KeyPath
from sceneq_tools.graph_problem import Problem

SENDS, HEARS = "robot", "robots"
"""Parameters of a node: whose frames it sends, and whose it reads beside those of the graph's."""


def robot_problems(graph: Graph, document: Document) -> Iterator[Problem]:
    """Yield, for each other robot, the kinds of nodes that read frames and none of them its own.

    Its keyframes would be sent again and again to nobody.
    """
    readers = _readers(graph)
    for sender in graph.nodes:
        robot = sender.params.get(SENDS) if _has(sender, SENDS) else None
        if not isinstance(robot, str) or robot == graph.robot:
            continue
        for nodes in readers.values():
            if any(robot in _heard(node) for node in nodes.values()):
                continue
            path: KeyPath = ("nodes", next(iter(nodes)), "params", HEARS)
            message = f"does not name {robot!r}, whose frames {sender.id!r} sends"
            shown, hint = shown_path(document, path), f"robots: [{robot}]"
            yield Problem(document.where(path), shown, message, hint=hint)


def _readers(graph: Graph) -> dict[str, dict[int, GraphNode]]:
    """Return the nodes that read frames, of each kind, by where they stand in the graph."""
    readers: dict[str, dict[int, GraphNode]] = {}
    for index, node in enumerate(graph.nodes):
        if _has(node, HEARS):
            readers.setdefault(node.node_kind, {})[index] = node
    return readers


def _heard(node: GraphNode) -> list[object]:
    """Return whom a node names; what is no list is told where parameters are checked."""
    named = node.params.get(HEARS)
    return named if isinstance(named, list) else []


def _has(node: GraphNode, name: str) -> bool:
    """Tell whether nodes of this kind have the parameter; an unknown kind has none."""
    try:
        params_class = load("nodes", node.node_kind, ()).Params
    except ParamError:
        return False
    return name in params_class.__dataclass_fields__
