"""What crosses the links between the machines of a graph, and whether it fits."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from sceneq_schemas import topics
from sceneq_schemas.topics import Topic
from sceneq_tools.graph import Graph, GraphNode

READS: dict[str, tuple[Topic, ...]] = {
    "segmentation": (topics.FRAME,),
    "mapping": (topics.FRAME, topics.MASK),
    "views": (topics.FRAME, topics.MAP_DELTA),
    "encoding": (topics.VIEW_DELTA, topics.VIEW_IMAGE),
    "routing": (topics.MAP_DELTA, topics.VIEW_DELTA, topics.FEATURE_DELTA, topics.POSE),
    "mirror": (topics.MAP_DELTA, topics.VIEW_DELTA, topics.FEATURE_DELTA),
    "viewer": (
        *(topics.FRAME, topics.MASK, topics.MAP_DELTA, topics.VIEW_DELTA, topics.FEATURE_DELTA),
    ),
    "recorder": (topics.FRAME, topics.POSE, topics.MASK, topics.MAP_DELTA, topics.VIEW_DELTA),
}
"""Kind of node -> the streams it reads. Questions, answers and health are small beside them."""

KB: dict[Topic, float] = {
    topics.POSE: 0.2,
    topics.MASK: 8,
    topics.MAP_DELTA: 450,
    topics.VIEW_DELTA: 8,
    topics.VIEW_IMAGE: 30,
    topics.FEATURE_DELTA: 20,
    topics.LABEL_DELTA: 0.5,
}
"""Kilobytes a keyframe of 640 x 480 as the link carries them, compressed (docs/deployment.md)."""
COLOUR_KB = {"raw": 922.0, "jpeg": 60.0}
DEPTH_KB = {"raw": 614.0, "zstd": 450.0, "delta": 260.0}
"""Of a depth image with 2 mm of noise; a sensor that rounds has 90 with either codec."""
ROUNDED_KB = {"raw": 614.0, "zstd": 92.0, "delta": 85.0}
USUAL_HZ = 3.0
BITS_A_KB = 8e-3


@dataclass(frozen=True, slots=True)
class Crossing:
    """One stream that is written on ``source`` and read on ``target``; ``mbit_s`` at most."""

    source: str
    target: str
    stream: str
    mbit_s: float


def crossings(graph: Graph, rounded: bool = False) -> list[Crossing]:
    """Return every stream that crosses, once for each machine that reads it.

    ``rounded``: the depth sensor rounds to its steps, as structured light does.
    """
    machine_of = {node.node_kind: node.deploy.machine for node in graph.nodes}
    rate_hz = _keyframes_hz(graph)
    found: dict[tuple[str, str, str], float] = {}
    for node in graph.nodes:
        for topic in READS.get(node.node_kind, ()):
            source = machine_of.get(topic.writer)
            if source is None or source == node.deploy.machine:
                continue
            place = (source, node.deploy.machine, topic.name)
            mbit_s = BITS_A_KB * _kilobytes(topic, graph, rounded) * rate_hz
            if _pulls(node):
                place, mbit_s = (*place[:2], "pulled"), _pull_mbit_s(node)
            found[place] = max(found.get(place, 0.0), mbit_s)
    return [Crossing(*place, mbit_s) for place, mbit_s in found.items()]


def overloads(graph: Graph) -> Iterator[tuple[str, str]]:
    """Yield each machine whose link would be too thin, and what it would have to carry."""
    for name, machine in graph.machines.items():
        streams = [one for one in crossings(graph) if one.source == name]
        total = sum(one.mbit_s for one in streams)
        limit = machine.uplink_mbit_s
        if limit is not None and total > limit:
            worst = max(streams, key=lambda one: one.mbit_s)
            most = f"most of it {worst.stream} ({worst.mbit_s:.1f})"
            yield name, f"{name} would send up to {total:.1f} Mbit/s, {most}"


def _kilobytes(topic: Topic, graph: Graph, rounded: bool) -> float:
    if topic is not topics.FRAME:
        return KB[topic]
    params = _ingest(graph)
    depth = ROUNDED_KB if rounded else DEPTH_KB
    return COLOUR_KB[params.get("rgb_codec", "raw")] + depth[params.get("depth_codec", "raw")]


def _keyframes_hz(graph: Graph) -> float:
    params = _ingest(graph)
    keyframes, rate_hz = params.get("keyframes") or {}, params.get("rate_hz") or 0.0
    if keyframes.get("kind") == "every" and rate_hz:
        return float(rate_hz / keyframes.get("every", 10))
    if keyframes.get("kind") == "interval" and keyframes.get("period_s"):
        return float(1 / keyframes["period_s"])
    return USUAL_HZ


def _ingest(graph: Graph) -> dict[str, Any]:
    return next((node.params for node in graph.nodes if node.node_kind == "ingest"), {})


def _pulls(node: GraphNode) -> bool:
    return isinstance(node.params.get("pull"), dict)


def _pull_mbit_s(node: GraphNode) -> float:
    return float(node.params["pull"].get("mbit_s", 4.0))
