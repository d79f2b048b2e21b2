"""A recording run through the nodes in this process, for the benches that need a map."""

import re
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from sceneq_nodes._frame_files import FrameFiles
from sceneq_tools import playing
from sceneq_tools.batch import ENCODING, Batch
from sceneq_tools.bench.measurement import Options
from sceneq_tools.errors import UserError
from sceneq_tools.graph import GraphNode
from sceneq_tools.graph_plan import Plan

FRAME = re.compile(r"frame-(\d+)\.")


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


@contextmanager
def first_frames(options: Options) -> Iterator[Options]:
    """Yield options with a source of ``options.frames`` frames, for who plays all there are.

    Raises:
        UserError: the source is no folder of frames that could be shortened.
    """
    if options.frames is None or options.source is None:
        yield options
        return
    with tempfile.TemporaryDirectory(prefix="sq") as folder:
        short = Path(folder) / options.source.resolve().name
        short.mkdir()
        _link_frames(options.source.resolve(), short, options.frames)
        yield replace(options, source=short)


def _link_frames(source: Path, short: Path, frames: int) -> None:
    """Fill ``short`` with links to the files of the first frames, and to those of no frame."""
    try:
        kept = set(FrameFiles(source).numbers[:frames])
    except ValueError as error:
        raise UserError(f"--frames: {error}", 2) from error
    for path in source.iterdir():
        number = FRAME.match(path.name)
        if number is None or int(number[1]) in kept:
            (short / path.name).symlink_to(path)


def play(batch: Batch, options: Options) -> int:
    """Run it to the end, or to ``options.frames``; return how many frames were played."""
    return playing.play(batch.stages(), options.quiet, most_frames=options.frames)
