"""Nodes with files that a test opens; they are closed when it ends."""

from collections.abc import Callable

from sceneq_nodes._bus import Bus, Node

_closing: list[Callable[[], None]] = []


def opened(node: Node, bus: Bus) -> None:
    """Open ``node``, until ``closed`` or to the end of the test."""
    node.open(bus)
    _closing.append(node.close)


def closed(close: Callable[[], None]) -> None:
    """Call ``close`` of a node, now rather than at the end."""
    if close in _closing:
        _closing.remove(close)
    close()


def close_all() -> None:
    """Close what is still open."""
    while _closing:
        _closing.pop()()
