"""A graph with everything in it on a recording of a small room, for many tests to look at."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from support.live_graph import LiveGraph, free_port, write_graph
from support.recording import write_recording
from support.room import Room

FRAMES = 12
NODES = ("ingest", "segmentation", "mapping", "views", "encoding", "routing", "reasoning")
"""There is a gateway, too."""
RED_BALL, BLUE_BOX = (-0.35, 0.95, 0.84), (0.3, 1.0, 0.82)
"""Where they are, in metres."""


@dataclass(frozen=True)
class SharedRoom:
    """The recording, a graph file for it, and that graph."""

    recording: Path
    graph: Path
    live: LiveGraph


def write_room(folder: Path) -> Path:
    """Write the recording."""
    small = Room(size=(320, 240), focal_px=260.0)
    return write_recording(folder / "room", FRAMES, small)


@contextmanager
def settled_room(folder: Path, runtime: Path) -> Iterator[SharedRoom]:
    """Run the graph, which knows all of the room when the block begins."""
    recording = write_room(folder)
    graph = write_graph(folder, recording)
    with graph.open("a") as file:
        file.write(f"  - id: gateway\n    params: {{port: {free_port()}}}\n")
    live = LiveGraph(graph, recording, runtime)
    try:
        live.wait_until_settled()
        yield SharedRoom(recording, graph, live)
    finally:
        assert live.close() == 0
