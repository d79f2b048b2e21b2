"""A robot that maps a recording and a server that mirrors it, each with its own router."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from sceneq_tools.chaos.namespaces import Machine, Pair

LOCAL = "tcp/127.0.0.1:7447"
PORT = 7448
SMALL_BUFFER = "#so_sndbuf=32768"
"""Frames wait in the router, where questions overtake them, rather than in the socket."""
START_S = 120.0
STOP_S = 15.0
POLL_S = 0.1
EDGE, SERVER = "edge", "server"
HERE, THERE, PULLED = "here", "there", "pulled"
MIRRORED = {"map": "mapping", "views": "views", "features": "encoding"}
"""What is mirrored, and who writes it."""
SAMPLE = Path(__file__).parents[1] / "sample"


class BrokenError(Exception):
    """The graph does not do what it is to; the text says what was waited for."""


@dataclass(frozen=True, slots=True)
class Setup:
    """``rate_hz``: frames a second; ``pull_s``: how often the second mirror looks for changes."""

    source: Path = SAMPLE
    rate_hz: float = 2.0
    pull_s: float = 1.0
    pull_mbit_s: float = 20.0


def faulty_graph(pair: Pair, setup: Setup, work: Path) -> dict[str, Any]:
    """Return the graph of a robot that does everything itself, and a server with two mirrors."""
    hashed = {"encoder": {"kind": "hash"}}
    pull = {"every_s": setup.pull_s, "mbit_s": setup.pull_mbit_s}
    return {
        **machines(pair),
        "store": str(work / "store"),
        "nodes": [
            *mapping_nodes(setup.source, setup.rate_hz),
            node("encoding", EDGE, params=hashed),
            node("routing", EDGE, params={**hashed, "labels": ["chair", "table", "lamp"]}),
            node(THERE, SERVER, kind="mirror"),
            node(PULLED, SERVER, kind="mirror", params={"pull": pull}),
        ],
    }


def machines(pair: Pair, metadata: str = SMALL_BUFFER) -> dict[str, Any]:
    """Return scene and machines of a graph whose link has ``metadata``."""
    joins = f"tcp/{pair.server.host}:{PORT}{metadata}"
    return {
        "scene": "room",
        "watchdog": {"silent_s": 600.0, "busy_s": 600.0},  # nodes are stopped on purpose
        "machines": {
            EDGE: {"router": {"listen": [LOCAL], "connect": [joins]}},
            SERVER: {"router": {"listen": [LOCAL, f"tcp/0.0.0.0:{PORT}{metadata}"]}},
        },
    }


def mapping_nodes(source: Path, rate_hz: float) -> list[dict[str, Any]]:
    """Return the nodes that map a recording on the robot, again and again, and mirror it there."""
    ingest = {
        "source": {"kind": "folder", "path": str(source), "loop": True},
        "rate_hz": rate_hz,
        "keyframes": {"kind": "every", "every": 1},
        "rgb_codec": "jpeg",
        "depth_codec": "delta",
    }
    segmenter = {"kind": "files", "path": str(source)}
    return [
        node("ingest", EDGE, params=ingest),
        node("segmentation", EDGE, params={"segmenter": segmenter}),
        node("mapping", EDGE),
        node("views", EDGE),
        node(HERE, EDGE, kind="mirror"),
    ]


def node(name: str, machine: str, **rest: Any) -> dict[str, Any]:
    """Return one node of a graph."""
    return {"id": name, "deploy": {"machine": machine}, **rest}


class RobotAndServer:
    """Both parts of a graph; start and stop them in a ``with`` block.

    Args:
        pair: the machines.
        graph: what to run, with a mirror on the robot and others on the server.
        work: an empty folder with a short name.
        mirrors: those on the server that are to become equal to the robot's.
    """

    def __init__(
        self,
        pair: Pair,
        graph: dict[str, Any],
        work: Path,
        mirrors: Sequence[str] = (THERE, PULLED),
    ) -> None:
        self._work = work
        self._mirrors = mirrors
        self._machines = {EDGE: pair.edge, SERVER: pair.server}
        self._file = work / "graph.yaml"
        self._file.write_text(yaml.safe_dump(graph))
        self._processes: list[subprocess.Popen[str]] = []
        self._health: dict[str, dict[str, dict[str, Any]]] = {EDGE: {}, SERVER: {}}

    def __enter__(self) -> "RobotAndServer":
        return self

    def __exit__(self, *_: object) -> None:
        for process in reversed(self._processes):
            self._end(process)

    def start(self, machine: str) -> None:
        """Start the part of one machine, and listen to its health."""
        where = self._machines[machine]
        logs = self._work / f"logs-{machine}"
        self._run(
            where, machine, "up", str(self._file), "--machine", machine, "--log-dir", str(logs)
        )
        self.wait(f"the router of {machine}", lambda: self._listens(where))
        listener = self._spawn(
            where, [sys.executable, "-m", "sceneq_tools.chaos.health_lines", LOCAL]
        )
        threading.Thread(target=self._hear, args=(machine, listener), daemon=True).start()

    def values(self, machine: str, node: str) -> dict[str, Any]:
        """Return what a node said last, as heard on a machine; {} before it said anything."""
        return dict(self._health[machine].get(node, {}))

    def pid(self, machine: str, node: str) -> int:
        """Return the process of a node.

        Raises:
            BrokenError: it said nothing yet.
        """
        pid = self.values(machine, node).get("pid")
        if not isinstance(pid, int):
            raise BrokenError(f"{node} on {machine} is not there")
        return pid

    def kill(self, machine: str, node: str) -> None:
        """Kill a node with -9, and wait until its successor is ready."""
        old = self.pid(machine, node)
        os.kill(old, signal.SIGKILL)

        def is_back() -> bool:
            now = self.values(machine, node)
            return now.get("pid") not in (None, old) and now.get("state") == "ready"

        self.wait(f"{node} to come back", is_back)

    @contextlib.contextmanager
    def still(self) -> Iterator[None]:
        """Let no frame come for the length of the block."""
        ingest = self.pid(EDGE, "ingest")
        os.kill(ingest, signal.SIGSTOP)
        try:
            yield
        finally:
            os.kill(ingest, signal.SIGCONT)

    def frames(self) -> int:
        """Return the newest keyframe in the map, counted from 1."""
        return int(self.values(EDGE, "mapping").get("values", {}).get("frame_seq", -1)) + 1

    def mirrored(self, machine: str, mirror: str) -> dict[str, str]:
        """Return ``epoch:seq`` and digest of everything a mirror holds."""
        said = self.values(machine, mirror).get("values", {})
        names = [name for one in MIRRORED for name in (one, f"{one}_digest")]
        return {name: said[name] for name in names if name in said}

    def difference(self) -> str:
        """Return in what the mirrors differ from the writers or each other, '' when in nothing."""
        here = self.mirrored(EDGE, HERE)
        for name, writer in MIRRORED.items():
            written = self.values(EDGE, writer).get("values", {}).get(name)
            if written is None or here.get(name) != written:
                return f"{name} is {written} at {writer}, {here.get(name)} in the robot's mirror"
        for mirror in self._mirrors:
            there = self.mirrored(SERVER, mirror)
            for name, value in here.items():
                if there.get(name) != value:
                    return f"{name} is {value} on the robot, {there.get(name)} in {mirror}"
        return ""

    def wait(self, what: str, look: Callable[[], Any], patience_s: float = START_S) -> float:
        """Return the seconds until ``look`` was true; raise ``BrokenError`` when it is not."""
        began_s = time.monotonic()
        while not look():
            waited_s = time.monotonic() - began_s
            if waited_s > patience_s:
                raise BrokenError(f"waited {waited_s:.0f} s for {what}")
            time.sleep(POLL_S)
        return time.monotonic() - began_s

    def _run(self, where: Machine, name: str, *arguments: str) -> None:
        with (self._work / f"{name}.log").open("w") as log:
            command = [sys.executable, "-m", "sceneq_tools", *arguments]
            self._spawn(where, command, log)

    def _spawn(
        self, where: Machine, command: list[str], log: Any = subprocess.PIPE
    ) -> "subprocess.Popen[str]":
        process = subprocess.Popen(
            where.command(*command),
            stdin=subprocess.PIPE,
            stdout=log,
            stderr=subprocess.DEVNULL if log is subprocess.PIPE else subprocess.STDOUT,
            text=True,
            cwd=self._work,
        )
        self._processes.append(process)
        return process

    def _listens(self, where: Machine) -> bool:
        port = f":{int(LOCAL.rpartition(':')[2]):04X} "
        done = subprocess.run(where.command("cat", "/proc/net/tcp"), capture_output=True, text=True)
        return any(port in line[:24] for line in done.stdout.splitlines())

    def _hear(self, machine: str, listener: "subprocess.Popen[str]") -> None:
        assert listener.stdout is not None
        for line in iter(listener.stdout.readline, ""):
            said = json.loads(line)
            self._health[machine][said["node"]] = said

    def _end(self, process: "subprocess.Popen[str]") -> None:
        assert process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            process.stdin.close()
        process.send_signal(signal.SIGINT)
        try:
            process.wait(STOP_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        if process.stdout is not None:
            process.stdout.close()
