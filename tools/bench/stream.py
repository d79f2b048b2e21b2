"""How many keyframes a second go through the nodes as processes, none of them dropped."""

import json
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter

from sceneq_schemas.topics import MAP_DELTA, VIEW_DELTA
from sceneq_tools.batch import INGEST, Batch
from sceneq_tools.bench.measurement import Measurement, Options
from sceneq_tools.bench.recording import first_frames, open_plan, play, replace_params
from sceneq_tools.chaos.live_graph import LiveGraph
from sceneq_tools.errors import UserError
from sceneq_tools.graph_plan import Plan

VIEWS = "views"
NODES = (INGEST, "segmentation", "mapping", VIEWS)
LOOKED_AT = ("frames_observed", "frames_kept_out")
BESIDE = "in one process"
AT_ONCE_HZ = 1e6
"""In one process nobody falls behind, so nothing has to be waited for."""


def stream(options: Options) -> Iterator[Measurement]:
    """Run the recording as fast as it goes, as processes and beside that in this one.

    Raises:
        UserError: a recording of less than two keyframes, or one that cannot be shortened.
    """
    with first_frames(options) as shortened:
        plan = open_plan(shortened)
        nodes = tuple(node for node in plan.nodes if node.node_kind in NODES)
        alone_hz = _alone_hz(_with_ingest(replace(plan, nodes=nodes), AT_ONCE_HZ), shortened)
        value_hz = _processes_hz(_with_ingest(replace(plan, nodes=nodes), 0.0))
    yield Measurement(f"keyframes, {len(nodes)} processes", value_hz, "/s", BESIDE, alone_hz)


def rate_hz(keyframes: int, took_s: float) -> float:
    """Return how often a second a keyframe was done: the first one starts the clock.

    Raises:
        UserError: less than two of them.
    """
    if keyframes < 2:
        raise UserError("at least two keyframes are needed", 2)
    return (keyframes - 1) / took_s


def _with_ingest(plan: Plan, rate_hz: float) -> Plan:
    """Return the plan in which every frame is a keyframe."""
    params = {"rate_hz": rate_hz, "keyframes": {"kind": "every", "every": 1}}
    nodes = (
        replace_params(node, params) if node.node_kind == INGEST else node for node in plan.nodes
    )
    return replace(plan, nodes=tuple(nodes))


def _alone_hz(plan: Plan, options: Options) -> float:
    batch = Batch(plan)
    try:
        start_s = perf_counter()
        return play(batch, options) / (perf_counter() - start_s)
    finally:
        batch.close()


def _processes_hz(plan: Plan) -> float:
    """Return the keyframes a second, from the first in the map to the last with its views."""
    with tempfile.TemporaryDirectory(prefix="sq") as folder:
        graph = Path(folder) / "graph.json"
        nodes = [{"id": n.id, "kind": n.node_kind, "params": n.params} for n in plan.nodes]
        graph.write_text(json.dumps({"scene": plan.scene, "nodes": nodes}))
        live = LiveGraph(graph, None, Path(folder))
        try:
            return _played_hz(live, plan.scene)
        finally:
            live.close()


def _played_hz(live: LiveGraph, scene: str) -> float:
    stamps_s: list[float] = []
    for topic in (MAP_DELTA, VIEW_DELTA):
        live.client.subscribe(topic.key(scene=scene), lambda *_: stamps_s.append(perf_counter()))
    live.wait(lambda: live.value(INGEST, "state") == "finished")
    keyframes = int(live.value(INGEST, "keyframes"))
    live.wait(lambda: sum(live.counter(VIEWS, name) for name in LOOKED_AT) == keyframes)
    return rate_hz(keyframes, max(stamps_s) - min(stamps_s))
