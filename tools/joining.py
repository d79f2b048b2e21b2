"""Joining a running graph as a node of its own, which the graph does not know of."""

import os
import time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sceneq_nodes._bus import Context
    from sceneq_nodes._client import Client

PATIENCE_S, POLL_S = 20.0, 0.5


def join(kind: str, scene: str | None, router: str) -> "Context":
    """Return where a node of ``kind`` would run: scene, robot and sensor as the graph has them.

    A graph that is starting gets some seconds; ``UserError`` when there is none.
    """
    from sceneq_nodes._bus import Context
    from sceneq_tools import scenes

    with scenes.connect(router) as client:
        told = _wait_for(client, scene)
        name = scenes.need_scene(client, scene)
    return Context(
        node=f"{kind}-{os.getpid()}",
        scene=name,
        robot=str(told.get(name, {}).get("robot", "robot")),
        sensor=str(told.get(name, {}).get("sensor", "camera")),
    )


def _wait_for(client: "Client", scene: str | None) -> dict[str, dict[str, Any]]:
    """Return what the scenes say of themselves; a graph that is starting needs a few seconds."""
    from sceneq_tools.scenes import scene_status

    deadline_s = time.monotonic() + PATIENCE_S
    while True:
        told = scene_status(client)
        if (scene in told if scene else told) or time.monotonic() > deadline_s:
            return told
        time.sleep(POLL_S)
