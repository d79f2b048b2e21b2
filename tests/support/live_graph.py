"""`sceneq up` on a recording as a process, on a port of its own."""

from sceneq_tools.chaos.live_graph import LABELS, LiveGraph, run, write_graph
from sceneq_tools.ports import free_port

__all__ = ["LABELS", "LiveGraph", "free_port", "run", "write_graph"]
