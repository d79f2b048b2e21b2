"""A recording run through the nodes in this process, for the benches that need a map."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sceneq_tools import playing
from sceneq_tools.batch import ENCODING, Batch
from sceneq_tools.bench.measurement import Options
from sceneq_tools.errors import UserError
from sceneq_tools.graph import GraphNode
from sceneq_tools.graph_plan import Plan


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
    from sceneq_tools.map_plan import map_plan

    if options.source is None:
        raise UserError("a folder of frames is needed: --source FOLDER", 2)
    return map_plan(options.source, options.graph)


def play(batch: Batch, options: Options) -> int:
    """Run it to the end, or to ``options.frames``; return how many frames were played."""
    return playing.play(batch.stages(), options.quiet, most_frames=options.frames)
