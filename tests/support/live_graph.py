"""`sceneq up` on a recording as a process, on a port of its own."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

T = TypeVar("T")
PATIENCE_S = 60.0
GRAPH = """\
nodes:
  - id: ingest
    params: {{source: {{kind: folder, path: .}}, rate_hz: 0, keyframes: {{kind: every, every: 1}}}}
  - id: segmentation
    params: {{segmenter: {{kind: {segmenter}}}}}
  - id: mapping
  - id: views
  - id: encoding
    params: {{encoder: {{kind: hash}}}}
  - id: routing
    params: {{encoder: {{kind: hash}}, labels: [{labels}]}}
  - id: reasoning
"""
LABELS = "ball, box, table, wall, floor"


def write_graph(folder: Path, recording: Path, segmenter: str = "files") -> Path:
    """Write a graph without trained weights, which a person would start the same way."""
    spec = f"files, path: {recording}" if segmenter == "files" else segmenter
    path = folder / "graph.yaml"
    path.write_text(GRAPH.format(segmenter=spec, labels=LABELS))
    return path


class LiveGraph:
    """A running graph; ``run`` types a command beside it."""

    def __init__(self, graph: Path, recording: Path | None, runtime: Path, *options: str) -> None:
        self.port = free_port()
        self.endpoint = f"tcp/127.0.0.1:{self.port}"
        self.log = graph.parent / f"up-{self.port}.log"
        source = ["--source", str(recording)] if recording else []
        command = ["up", str(graph), *source, "--port", str(self.port)]
        with self.log.open("wb") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "sceneq_tools", *command, *options],
                cwd=graph.parent,
                env=os.environ | {"XDG_RUNTIME_DIR": str(runtime), "XDG_STATE_HOME": str(runtime)},
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
        """Return what every node says of itself."""
        done = self.sceneq("status", "--json")
        return {n["node"]: n for n in json.loads(done.stdout)["nodes"]} if done.stdout else {}

    def pids(self) -> dict[str, int]:
        """Return the newest process of every node, read from what `up` printed."""
        found = re.findall(r"(\w+) +\w+ \(pid (\d+)\)", self.log.read_text())
        return {node: int(pid) for node, pid in found}

    def wait(self, what: Callable[[], T]) -> T:
        """Return the first true value of ``what``."""
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            assert self.process.poll() is None, self.log.read_text()
            if value := what():
                return value
            time.sleep(0.1)
        raise AssertionError(f"waited {PATIENCE_S} s; {self._story()}")

    def _story(self) -> str:
        """What the graph printed and what its nodes say, for whoever has only a log to read."""
        return f"the graph printed:\n{self.log.read_text()}\n{self.sceneq('status').stdout}"

    def wait_until_settled(self) -> None:
        """Wait until the recording is over and everything seen is described."""

        def settled() -> bool:
            nodes = self.status()
            played = nodes.get("ingest", {}).get("values", {}).get("state") == "finished"
            return played and nodes["encoding"]["values"].get("pending") == 0

        self.wait(settled)

    def close(self) -> int:
        """Stop like Ctrl-C does; return the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            return self.process.wait(15)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise


def run(*command: str) -> "subprocess.CompletedProcess[str]":
    """Run a command and return what it printed."""
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])
