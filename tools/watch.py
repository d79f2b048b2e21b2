"""``sceneq status --watch``: what flows in a running graph, anew every two seconds."""

import sys
import time
from typing import Any

import typer

from sceneq_nodes._client import Client
from sceneq_tools import scenes
from sceneq_tools.rates import Rates
from sceneq_tools.status import HeardNodes, NodeStatus
from sceneq_tools.table import print_table

PERIOD_S = 2.0
COLUMNS = (
    *("node", "state", "in/s", "out/s", "dropped/s", "dropped", "bad"),
    *("queue", "idle s", "MiB"),
)
CLEAR = "\033[H\033[2J"


def watch(client: Client) -> None:
    """Print until Ctrl-C."""
    heard, rates = HeardNodes(), Rates()
    heard.listen(client)
    while True:
        time.sleep(PERIOD_S)
        told = scenes.scene_status(client)
        if sys.stdout.isatty():
            typer.echo(CLEAR, nl=False)
        now_s = time.monotonic()
        rows = [
            _row(node, up, rates.of(node.node, node.flows, now_s)) for node, up in heard.nodes()
        ]
        print_table(COLUMNS, rows)
        for scene, said in told.items():
            typer.echo(_scene_line(scene, said))


def _row(node: NodeStatus, up: bool, rate: dict[str, float]) -> tuple[str, ...]:
    state = node.state if up or node.state != "ready" else "silent"
    flows = (_shown(rate.get(name)) for name in ("in", "out", "dropped"))
    lost = (str(node.flows.get(name, 0)) for name in ("dropped", "undecodable"))
    return (
        *(node.node, state, *flows, *lost),
        *(str(node.waiting), _shown(node.idle_s), _shown(node.rss_mb)),
    )


def _scene_line(scene: str, said: dict[str, Any]) -> str:
    revision = said.get("map", {})
    return (
        f"scene {scene}: {said.get('instances', 0)} instances, {said.get('answerable', 0)} "
        f"answerable, map {revision.get('epoch', 0)}:{revision.get('seq', 0)}, "
        f"{revision.get('age_s', 0.0):.1f} s old"
    )


def _shown(value: float | None) -> str:
    return "-" if value is None else f"{value:.1f}"
