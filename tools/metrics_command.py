"""``sceneq metrics``: the numbers of a running graph for Prometheus."""

from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint

if TYPE_CHECKING:
    from sceneq_tools.status import HeardNodes


def run(
    serve: Annotated[
        str | None, typer.Option(metavar="[HOST:]PORT", help="Serve them on HTTP until Ctrl-C.")
    ] = None,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Print the numbers of a running graph as OpenMetrics text, or serve them at /metrics."""
    from sceneq_tools import scenes
    from sceneq_tools.errors import UserError
    from sceneq_tools.metrics import as_text
    from sceneq_tools.status import HeardNodes

    heard = HeardNodes()
    with scenes.connect(connect) as client:
        if serve is not None:
            heard.listen(client)
            _serve(heard, *_address(serve))
            return
        heard.listen_to_all(client)
    if not heard.nodes():
        raise UserError(f"a router is at {connect}, but no node ({scenes.START_HINT})")
    typer.echo(as_text(heard), nl=False)


def _address(text: str) -> tuple[str, int]:
    from sceneq_tools.errors import UserError

    host, _, port = text.rpartition(":")
    if not port.isdigit() or not 0 < int(port) < 65536:
        raise UserError(f"--serve {text}: expected PORT or HOST:PORT", 2)
    return host.strip("[]") or "127.0.0.1", int(port)


def _serve(heard: "HeardNodes", host: str, port: int) -> None:
    """Serve until Ctrl-C."""
    import threading

    from prometheus_client import CollectorRegistry, start_http_server

    from sceneq_tools.errors import UserError
    from sceneq_tools.metrics import GraphCollector

    registry = CollectorRegistry()
    registry.register(GraphCollector(heard))
    try:
        server, thread = start_http_server(port, host, registry)
    except OSError as error:
        raise UserError(f"cannot listen on {host}:{port}: {error.strerror}") from error
    typer.echo(f"http://{host}:{port}/metrics")
    try:
        threading.Event().wait()
    finally:
        server.shutdown()
        thread.join()
