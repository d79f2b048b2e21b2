"""A source played through all nodes of a graph in one process, and a question about the map."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_schemas.topics import QUERY_INSTANCES
from sceneq_tools.batch import Batch
from sceneq_tools.graph import Override, load
from sceneq_tools.graph_check import check_nodes
from sceneq_tools.graph_plan import plan
from sceneq_tools.playing import FRAMES

PATIENCE_S = 90.0


def live_batch(graph: Path, spec: dict[str, Any]) -> Batch:
    """Return the nodes of a graph on a live source, every frame of which is a keyframe."""
    overrides = [
        Override("", ("scene",), "room", "--camera"),
        Override("ingest", ("source",), spec, "--camera"),
        Override("ingest", ("rate_hz",), 0.0, "--rate"),
    ]
    loaded, document = load(graph, overrides)
    check_nodes(loaded, document)
    return Batch(plan(loaded, document, "local"))


def play_live(batch: Batch, frames: int, more: Callable[[], None] = lambda: None) -> None:
    """Play so many frames of a source that never ends; ``more`` makes a camera go on."""
    deadline_s = time.monotonic() + PATIENCE_S
    for stage in batch.stages():
        for done in stage.steps:
            if stage.name == FRAMES and done >= frames:
                break
            assert time.monotonic() < deadline_s, f"{stage.name}: {done} of {frames} came"
            more()


def centre_of(batch: Batch, question: str) -> np.ndarray:
    """Return where the map has the thing, of which the answer must be sure."""
    reply = batch.get(QUERY_INSTANCES, {"q": question})
    assert reply is not None
    answer = json.loads(reply.payload)
    assert answer["status"] == "found", answer["instances"]
    assert answer["instances"][0]["p"] > 0.9
    return np.array(answer["instances"][0]["centre"])
