"""``--viewer`` of ``sceneq up``: a viewer node beside those of the graph."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from sceneq_tools.errors import UserError
from sceneq_tools.graph import GraphNode
from sceneq_tools.graph_plan import Plan

VIEWER = "viewer"


def with_viewer(plan: Plan, output: str | None) -> Plan:
    """Return the plan with a viewer that serves a page, writes a file or joins a Rerun viewer.

    Raises:
        UserError: ``output`` is none of them, Rerun is not installed, or the graph has one.
    """
    from sceneq_nodes._params import ParamError, validate
    from sceneq_nodes._viewer_output import OutputParams, need_rerun

    if output is None:
        return plan
    if any(node.id == VIEWER for node in plan.nodes):
        raise UserError("--viewer: the graph has a viewer already", 2)
    params = {"output": output_params(output)}
    try:
        need_rerun()
        validate(OutputParams, params["output"], ("--viewer",))
    except (ParamError, ValueError) as error:
        raise UserError(str(error), 2) from error
    return replace(plan, nodes=(*plan.nodes, GraphNode(id=VIEWER, params=params)))


def output_params(output: str) -> dict[str, Any]:
    """Return where the picture goes: ``serve``, a file ending in .rrd, or a viewer's URL."""
    if output == "serve":
        return {"serve": True}
    if "://" in output:
        return {"connect": output}
    if output.endswith(".rrd"):
        return {"save": str(Path(output).resolve())}
    known = "serve, FILE.rrd or rerun+http://HOST:PORT/proxy"
    raise UserError(f"--viewer {output}: expected {known}", 2)
