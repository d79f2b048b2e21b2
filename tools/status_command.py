"""``sceneq status``: how a running graph is."""

import json
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint

if TYPE_CHECKING:
    from sceneq_tools.status import NodeStatus

COLUMNS = (
    *("node", "state", "pid", "up s", "idle s", "MiB"),
    *("in", "out", "dropped", "bad", "queue"),
)


def run(
    as_json: Annotated[bool, typer.Option("--json", help="As JSON, for programs.")] = False,
    watched: Annotated[
        bool, typer.Option("--watch", help="With rates, anew every two seconds until Ctrl-C.")
    ] = False,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Show nodes and scenes of a running graph; exit code 1 when nothing runs."""
    from sceneq_tools import scenes
    from sceneq_tools.errors import UserError
    from sceneq_tools.status import node_status

    with scenes.connect(connect) as client:
        if watched:
            from sceneq_tools.watch import watch

            watch(client)
        told = scenes.scene_status(client)
        nodes = node_status(client)
    if as_json:
        typer.echo(json.dumps({"nodes": [n.as_json() for n in nodes], "scenes": told}, indent=2))
    elif nodes or told:
        _print(nodes, told)
    else:
        raise UserError(f"a router is at {connect}, but no node ({scenes.START_HINT})")


def _print(nodes: "list[NodeStatus]", told: dict[str, dict[str, Any]]) -> None:
    from sceneq_tools.table import print_table

    print_table(COLUMNS, [_row(node) for node in nodes])
    for node in nodes:
        values = dict(node.values)
        trouble = values.pop("trouble", "")
        if words := _inline({**values, **node.counters}):
            typer.echo(f"{node.node}: {words}")
        if trouble:
            typer.echo(f"{node.node}: TROUBLE {trouble}")
    for scene, said in told.items():
        typer.echo(f"scene {scene}: {_inline(said)}")
    if not told:
        typer.echo("no scene answers yet")


def _row(node: "NodeStatus") -> tuple[str, ...]:
    flows = (str(node.flows.get(name, "")) for name in ("in", "out", "dropped", "undecodable"))
    measures = (node.pid, node.uptime_s, node.idle_s, node.rss_mb)
    return (node.node, node.state, *map(_cell, measures), *flows, str(node.waiting))


def _cell(value: float | int | None) -> str:
    if value is None:
        return "-"
    return str(value) if isinstance(value, int) else f"{value:.1f}"


def _inline(said: dict[str, Any]) -> str:
    """Return ``a=1 b.c=2``; lists only by their length."""
    parts = []
    for name, value in said.items():
        if isinstance(value, dict):
            parts += [f"{name}.{part}" for part in _inline(value).split(" ") if part]
        elif isinstance(value, list):
            parts.append(f"{name}={len(value)}")
        elif isinstance(value, int | float | str) and str(value):
            parts.append(f"{name}={_short(value)}")
    return " ".join(parts)


def _short(value: float | int | str) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)[:40]
