"""``--record`` of ``sceneq up``: a recorder beside the nodes of the graph, there from the start."""

from dataclasses import replace
from pathlib import Path

from sceneq_tools.errors import UserError
from sceneq_tools.graph import GraphNode
from sceneq_tools.graph_plan import Plan

RECORDER, INGEST = "recorder", "ingest"


def with_recorder(plan: Plan, path: Path | None) -> Plan:
    """Return the plan with a recorder that ingest waits for, so that nothing is missed.

    Raises:
        UserError: the file is there already, has no folder, or the graph records already.
    """
    if path is None:
        return plan
    need_new_file(path)
    if any(node.node_kind == RECORDER for node in plan.nodes):
        raise UserError("--record: the graph has a recorder already", 2)
    recorder = GraphNode(id=RECORDER, params={"path": str(path.resolve())})
    return replace(plan, nodes=(*map(_waiting, plan.nodes), recorder))


def need_new_file(path: Path) -> None:
    """Refuse to write over a file, or into a folder that is not there."""
    if path.suffix != ".mcap":
        raise UserError(f"{path}: recordings are called .mcap", 2)
    if path.exists():
        raise UserError(f"{path}: is there already; take another name", 2)
    if not path.resolve().parent.is_dir():
        raise UserError(f"{path.parent}: no such folder", 2)


def _waiting(node: GraphNode) -> GraphNode:
    if node.node_kind != INGEST:
        return node
    from sceneq_nodes.ingest import IngestParams

    default = IngestParams.__dataclass_fields__["wait_for"].default
    wait_for = [*node.params.get("wait_for", default), RECORDER]
    return node.model_copy(update={"params": {**node.params, "wait_for": wait_for}})
