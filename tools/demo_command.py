"""``sceneq demo``: a recording through the real graph, questions meanwhile, then a picture."""

import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sceneq_tools.ask_command import show_evidence

if TYPE_CHECKING:
    from sceneq_nodes._client import Client
    from sceneq_tools.scenes import Asked

QUESTIONS = ("chair", "white mug", "the monitor on the table", "bicycle")
RATE_HZ = 30.0
READY_S = 60.0
SETTLE_S = 300.0
POLL_S = 1.0
ASK_EVERY_S = 4.0
STOP_S = 10.0


def run(
    source: Annotated[Path, typer.Argument(help="Folder of frames to read.")],
    out: Annotated[Path, typer.Argument(help="Folder to write into.")] = Path("out/demo"),
    question: Annotated[
        list[str] | None, typer.Option("--question", "-q", help="Ask this; repeat for more.")
    ] = None,
    graph: Annotated[
        Path | None, typer.Option(help="Default: ./graph.yaml, else the one in the package.")
    ] = None,
    rate: Annotated[float, typer.Option(help="Source frames a second.")] = RATE_HZ,
) -> None:
    """Run a recording through the graph, ask while it runs, write the map and a picture."""
    port = _free_port()
    options = ["--source", str(source), "--rate", f"{rate:g}", "--port", str(port)]
    command = [sys.executable, "-m", "sceneq_tools", "up", *options]
    up = subprocess.Popen([*command, str(graph)] if graph else command)
    try:
        _show(up, f"tcp/127.0.0.1:{port}", out, question or list(QUESTIONS))
    finally:
        up.send_signal(signal.SIGINT)
        try:
            up.wait(STOP_S)
        except subprocess.TimeoutExpired:
            up.kill()


def _show(up: "subprocess.Popen[bytes]", endpoint: str, out: Path, questions: list[str]) -> None:
    from sceneq_tools.collect import collect
    from sceneq_tools.export_command import getter, write_all

    with _connected(up, endpoint) as client:
        scene = _first_instances(up, client)
        _ask_while_it_plays(up, client, scene, questions)
        typer.echo("\nthe recording is over; the same questions to the whole map:")
        for number, text in enumerate(questions, 1):
            show_evidence(client, _ask(client, scene, text), out / f"evidence-{number}.png")
        write_all(collect(getter(client, scene), scene), out, rrd=False)
        typer.echo(f"picture: {out / 'instances.png'}")


def _connected(up: "subprocess.Popen[bytes]", endpoint: str) -> "Client":
    """Return a client as soon as the router answers."""
    from sceneq_nodes._client import Client

    deadline_s = time.monotonic() + READY_S
    while True:
        try:
            return Client(endpoint)
        except ConnectionError:
            _need_running(up)
            if time.monotonic() > deadline_s:
                raise
            time.sleep(POLL_S)


def _first_instances(up: "subprocess.Popen[bytes]", client: "Client") -> str:
    """Wait until there is something to ask about; return its scene."""
    from sceneq_tools.errors import UserError
    from sceneq_tools.scenes import scene_status

    deadline_s = time.monotonic() + READY_S
    while time.monotonic() < deadline_s:
        _need_running(up)
        for scene, status in scene_status(client).items():
            if status.get("answerable"):
                return scene
        time.sleep(POLL_S)
    raise UserError(f"no instance appeared within {READY_S:g} s (see: sceneq status)")


def _ask_while_it_plays(
    up: "subprocess.Popen[bytes]", client: "Client", scene: str, questions: list[str]
) -> None:
    """Put one question after the other until the last frame is described."""
    heard = _Heard(client)
    deadline_s, next_s, turn = time.monotonic() + SETTLE_S, 0.0, 0
    while not heard.settled() and time.monotonic() < deadline_s:
        _need_running(up)
        if time.monotonic() >= next_s and not heard.source_finished():
            typer.echo(f"\n{heard.progress()}")
            _ask(client, scene, questions[turn % len(questions)])
            turn, next_s = turn + 1, time.monotonic() + ASK_EVERY_S
        time.sleep(POLL_S)


def _ask(client: "Client", scene: str, text: str) -> "Asked":
    from sceneq_schemas.topics import QUERY_ASK
    from sceneq_tools.answer_text import as_text
    from sceneq_tools.scenes import ask

    asked = ask(client, QUERY_ASK, scene, {"q": text, "k": 3}, 10.0)
    typer.echo(as_text(asked.body))
    return asked


def _need_running(up: "subprocess.Popen[bytes]") -> None:
    from sceneq_tools.errors import UserError

    if up.poll() is not None:
        raise UserError("the graph stopped; the lines above say why", up.returncode or 1)


class _Heard:
    """The newest heartbeat of every node."""

    def __init__(self, client: "Client") -> None:
        from sceneq_schemas.topics import HEALTH
        from sceneq_tools.status import from_health

        self._values: dict[str, Any] = {}

        def note(key: str, encoding: str, payload: bytes) -> None:
            status = from_health(key, payload)
            if status is not None:
                self._values[status.kind] = status.values

        client.subscribe(HEALTH.selector(), note)

    def source_finished(self) -> bool:
        """Tell whether the last frame is published."""
        return bool(self._values.get("ingest", {}).get("state") == "finished")

    def settled(self) -> bool:
        """Tell whether everything seen is described."""
        pending = self._values.get("encoding", {}).get("pending")
        return self.source_finished() and pending == 0

    def progress(self) -> str:
        """Return how far the graph has come."""
        played = self._values.get("ingest", {}).get("frames", 0)
        instances = self._values.get("mapping", {}).get("instances", 0)
        return f"after {played} frames, {instances} instances in the map:"


def _free_port() -> int:
    import socket

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
