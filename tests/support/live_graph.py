"""`sceneq up` on a recording as a process, on a port of its own."""

from sceneq_tools.chaos.live_graph import LABELS, LiveGraph, free_port, run, write_graph

__all__ = ["LABELS", "LiveGraph", "free_port", "run", "write_graph"]
