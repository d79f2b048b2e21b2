"""`sceneq up` on a recording as a process, on a port of its own, and a client beside it."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from sceneq_tools.ports import free_port

if TYPE_CHECKING:
    from sceneq_nodes._client import Client
    from sceneq_tools.status import NodeStatus

T = TypeVar("T")
PATIENCE_S = 240.0
STOP_S = 60.0
POLL_S = 0.1
CONNECT_S = 10.0
BEGUN = ("playing", "ending", "finished")
TOLD = {"map": "mapping", "views": "views", "features": "encoding"}
"""What is told from node to node as changes, and by whom: each reports how far it is."""
LISTENERS = {"encoding": ("views",), "routing": ("map", "views", "features")}
GRAPH = """\
nodes:
  - id: ingest
    params: {{source: {{kind: folder, path: .}}, rate_hz: 0, keyframes: {{kind: every, every: 1}}}}
  - id: segmentation
    params: {{segmenter: {{kind: {segmenter}}}}}
  - id: mapping
    params: {mapping}
  - id: views
  - id: encoding
    params: {{encoder: {{kind: hash}}}}
  - id: routing
    params: {{encoder: {{kind: hash}}, labels: [{labels}]}}
  - id: reasoning
    params: {reasoning}
"""
LABELS = "ball, box, table, wall, floor"


def write_graph(
    folder: Path,
    recording: Path,
    segmenter: str = "files",
    mapping: str = "{}",
    reasoning: str = "{}",
) -> Path:
    """Write a graph without trained weights, which a person would start the same way.

    ``mapping`` and ``reasoning``: parameters of these nodes in YAML.
    """
    spec = f"files, path: {recording}" if segmenter == "files" else segmenter
    path = folder / "graph.yaml"
    params = {"segmenter": spec, "labels": LABELS, "mapping": mapping, "reasoning": reasoning}
    path.write_text(GRAPH.format(**params))
    return path


class LiveGraph:
    """A running graph; ``sceneq`` types a command beside it, ``client`` asks it directly."""

    def __init__(
        self,
        graph: Path,
        recording: Path | None,
        runtime: Path,
        *options: str,
        within: Sequence[str] = (),
        environment: Mapping[str, str] | None = None,
    ) -> None:
        """Start it; ``runtime`` is a folder with a short path, for sockets and logs.

        ``within``: a command that runs the one behind it, such as ``unshare``.
        """
        self.port = free_port()
        self.endpoint = f"tcp/127.0.0.1:{self.port}"
        self.log = graph.parent / f"up-{self.port}.log"
        self._client: Client | None = None
        source = ["--source", str(recording)] if recording else []
        command = ["up", str(graph), *source, "--port", str(self.port)]
        home = {"XDG_RUNTIME_DIR": str(runtime), "XDG_STATE_HOME": str(runtime)}
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                [*within, sys.executable, "-m", "sceneq_tools", *command, *options],
                cwd=graph.parent,
                env={**os.environ, **home, **(environment or {})},
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def sceneq(self, *arguments: str) -> "subprocess.CompletedProcess[str]":
        """Run one `sceneq` command against this graph."""
        return run(sys.executable, "-m", "sceneq_tools", *arguments, "--connect", self.endpoint)

    def zenoh_get(self, selector: str, decoder: str = "json") -> list[Any]:
        """Ask with the third-party command line; return the JSON values it prints."""
        cli = str(Path(sys.executable).with_name("zenoh"))
        mode = ("--mode", "client", "--connect", self.endpoint)
        done = run(cli, *mode, "get", "-s", selector, "--decoder", decoder)
        if decoder != "json":
            return [done.stdout] if done.stdout else []
        lines = [line for line in done.stdout.splitlines() if "{" in line]
        return [json.loads(line[line.index("{") :]) for line in lines]

    def status(self) -> dict[str, dict[str, Any]]:
        """Return what every node says of itself, as the command tells it."""
        done = self.sceneq("status", "--json")
        return {n["node"]: n for n in json.loads(done.stdout)["nodes"]} if done.stdout else {}

    @property
    def client(self) -> "Client":
        """A client of this process, which from now on hears the heartbeats."""
        if self._client is None:
            from sceneq_nodes._client import Client
            from sceneq_tools.status import HeardNodes

            client = self.wait(lambda: _connected(Client, self.endpoint))
            assert client is not None
            self._heard = HeardNodes()
            self._heard.listen(client)
            self._client = client
        return self._client

    def heard(self) -> "dict[str, NodeStatus]":
        """Return the newest heartbeat of every node."""
        assert self.client
        return {status.node: status for status, _ in self._heard.nodes()}

    def value(self, node: str, name: str) -> Any:
        """Return what the present process of a node last said, ``None`` before it says anything."""
        said = self.heard().get(node)
        return said.values.get(name) if said and said.pid == self.pids().get(node) else None

    def counter(self, node: str, name: str) -> int:
        """Return what the present process of a node has counted, 0 before it says anything."""
        said = self.heard().get(node)
        here = said and said.pid == self.pids().get(node)
        return said.counters.get(name, 0) if said and here else 0

    def is_up(self, node: str) -> bool:
        """Whether the present process of a node has said that it is ready."""
        said = self.heard().get(node)
        return bool(said and said.state == "ready" and said.pid == self.pids().get(node))

    def pids(self) -> dict[str, int]:
        """Return the newest process of every node, read from what `up` printed."""
        found = re.findall(r"(\w+) +\w+ \(pid (\d+)\)", self.log.read_text())
        return {node: int(pid) for node, pid in found}

    def wait(self, what: Callable[[], T], patience_s: float = PATIENCE_S) -> T:
        """Return the first true value of ``what``.

        Raises:
            TimeoutError: there was none; with what the graph printed.
            RuntimeError: the graph has ended.
        """
        deadline = time.monotonic() + patience_s
        while time.monotonic() < deadline:
            if self.process.poll() is not None:
                raise RuntimeError(f"the graph has ended; it printed:\n{self.log.read_text()}")
            if value := what():
                return value
            time.sleep(POLL_S)
        raise TimeoutError(f"waited {patience_s} s; {self._story()}")

    def _story(self) -> str:
        """What the graph printed and what its nodes say, for whoever has only a log to read."""
        return f"the graph printed:\n{self.log.read_text()}\n{self.sceneq('status').stdout}"

    def wait_until_begun(self) -> None:
        """Wait until frames are read; a short recording may be over before a heartbeat tells."""
        self.wait(lambda: self.value("ingest", "state") in BEGUN)

    def wait_until_settled(self) -> None:
        """Wait until the recording is over, everything seen is described, and every node knows."""
        self.wait(lambda: self.value("ingest", "state") == "finished")
        said = self._ages()
        self.wait(lambda: self._is_settled(said))

    def _ages(self) -> dict[str, float | None]:
        """When those that tell and listen have said what they said last."""
        who = {*TOLD.values(), *LISTENERS}
        return {name: one.uptime_s for name, one in self.heard().items() if name in who}

    def _is_settled(self, before: Mapping[str, float | None]) -> bool:
        """Whether nothing is on its way, as all say who have spoken since ``before``."""
        now = self._ages()
        if any(now[name] == said for name, said in before.items()):
            return False
        written = {what: self.value(who, what) for what, who in TOLD.items()}
        waited_for = (
            self.value(listener, what) == written[what]
            for listener, told in LISTENERS.items()
            for what in told
            if written[what] is not None and listener in self.pids()
        )
        described = self.value("encoding", "pending") == 0
        return described and self.value("ingest", "state") == "finished" and all(waited_for)

    def close(self) -> int:
        """Stop like Ctrl-C does; return the exit code."""
        if self._client is not None:
            self._client.close()
            self._client = None
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


def run(*command: str) -> "subprocess.CompletedProcess[str]":
    """Run a command and return what it printed."""
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)


def _connected(client: "type[Client]", endpoint: str) -> "Client | None":
    try:
        return client(endpoint, CONNECT_S)
    except ConnectionError:
        return None
