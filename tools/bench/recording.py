"""A recording run through the nodes in this process, for the benches that need a map."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sceneq_tools.batch import ENCODING, Batch
from sceneq_tools.bench.measurement import Options
from sceneq_tools.errors import UserError
from sceneq_tools.graph import GraphNode
from sceneq_tools.graph_plan import Plan
from sceneq_tools.progress import progress


def open_batch(options: Options) -> Batch:
    """Return the graph on ``options.source``, before its first frame; raise like ``open_plan``.

    One instance is described at a time: what is done ahead would be in the way of other stages.
    """
    plan = open_plan(options)
    nodes = tuple(
        replace_params(node, {"at_once": 1}) if node.node_kind == ENCODING else node
        for node in plan.nodes
    )
    return Batch(replace(plan, nodes=nodes))


def replace_params(node: GraphNode, params: Mapping[str, Any]) -> GraphNode:
    """Return a node of a graph with other parameters."""
    return node.model_copy(update={"params": {**node.params, **params}})


def open_plan(options: Options) -> Plan:
    """Return what to run on ``options.source``.

    Raises:
        UserError: no source, or one that cannot be read.
    """
    from sceneq_tools.graph import default_path, load
    from sceneq_tools.graph_check import check_nodes
    from sceneq_tools.graph_plan import plan
    from sceneq_tools.up_command import source_overrides

    if options.source is None:
        raise UserError("a folder of frames is needed: --source FOLDER", 2)
    overrides = source_overrides(options.source, None, 0.0, None, False, False, None)
    loaded, document = load(options.graph or default_path(), overrides)
    check_nodes(loaded, document)
    return plan(loaded, document, "local")


def play(batch: Batch, options: Options) -> int:
    """Run it to the end, or to ``options.frames``; return how many frames were played."""
    played = 0
    for stage in batch.stages():
        is_frames = stage.name == "frames"
        last = options.frames if is_frames else None
        with progress(stage.name, last or stage.total, quiet=options.quiet) as advance:
            done = 0
            for now in stage.steps:
                advance(now - done)
                done = now
                if last is not None and done >= last:
                    break
        played = done if is_frames else played
    return played
