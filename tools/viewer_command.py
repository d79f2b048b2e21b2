"""``sceneq viewer``: watch a running graph, from this machine or another one."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT

if TYPE_CHECKING:
    from sceneq_nodes._launch import Launch

WEB_PORT, GRPC_PORT = 9090, 9876
MAX_POINTS = 500_000


def run(
    serve: Annotated[
        bool, typer.Option("--serve", help="Offer a web page (what happens without options).")
    ] = False,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE.rrd", help="Write all of it to a file.")
    ] = None,
    connect: Annotated[
        str | None,
        typer.Option(metavar="URL", help="A Rerun viewer: rerun+http://HOST:9876/proxy."),
    ] = None,
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    router: Annotated[str, typer.Option(help="Router of the graph.")] = DEFAULT_ENDPOINT,
    host: Annotated[
        str, typer.Option(help="Who may see the page: 127.0.0.1 = this machine, 0.0.0.0 = all.")
    ] = "127.0.0.1",
    web_port: Annotated[int, typer.Option(help="Port of the web page.")] = WEB_PORT,
    grpc_port: Annotated[int, typer.Option(help="Port of the page's data.")] = GRPC_PORT,
    max_points: Annotated[
        int, typer.Option(min=1, help="Of a larger map so many points are shown.")
    ] = MAX_POINTS,
    superpoints: Annotated[
        bool, typer.Option("--superpoints", help="Show the superpoints as well.")
    ] = False,
) -> None:
    """Show map, camera, answers, rates and delays of a running graph in Rerun, until Ctrl-C."""
    from sceneq_nodes._viewer_output import need_rerun
    from sceneq_tools.errors import UserError

    output = {
        "serve": serve,
        "save": "" if save is None else str(save.resolve()),
        "connect": connect or "",
        "host": host,
        "web_port": web_port,
        "grpc_port": grpc_port,
    }
    try:
        need_rerun()
        params = {"output": output, "max_points": max_points, "superpoints": superpoints}
        code = _run(params, scene, router)
    except ValueError as error:
        raise UserError(str(error), 2) from error
    raise typer.Exit(code)


def _run(params: dict[str, Any], scene: str | None, router: str) -> int:
    """Join the graph as a node of its own; the graph does not know of it."""
    from sceneq_nodes._process import run_alone

    return run_alone(_launch(params, scene, router))


def _launch(params: dict[str, Any], scene: str | None, router: str) -> "Launch":
    from sceneq_nodes._launch import Launch
    from sceneq_tools.joining import join

    return Launch("viewer", join("viewer", scene, router), params, router)
