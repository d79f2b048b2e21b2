"""`sceneq up` with real processes: what dies comes back, and at the end nothing is left."""

import os
import queue
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from sceneq_tools.graph import GraphNode

from support.live_graph import free_port

pytestmark = pytest.mark.integration

PATIENCE_S = 90.0
TESTS = Path(__file__).parents[1]
GRAPH = """\
scene: room
watchdog: {{silent_s: 4.0, busy_s: 60.0}}
nodes:
  - {{id: left, kind: idle}}
  - {{id: right, kind: idle, params: {{fault: '{fault}'}}}}
"""


class Up:
    """A running `sceneq up` and the lines it prints."""

    def __init__(self, folder: Path, port: int, short: Path, fault: str = "") -> None:
        (folder / "graph.yaml").write_text(GRAPH.format(fault=fault))
        plugin = folder / "plugin" / "idle-1.0.dist-info"
        plugin.mkdir(parents=True, exist_ok=True)
        (plugin / "METADATA").write_text("Metadata-Version: 2.1\nName: idle\nVersion: 1.0\n")
        (plugin / "entry_points.txt").write_text("[sceneq.nodes]\nidle = support.idle_node:Idle\n")
        self.pids: set[int] = set()
        self.printed: list[str] = []
        self._lines: queue.Queue[str] = queue.Queue()
        options = ("up", "graph.yaml", "--port", str(port), "--log-dir", "logs")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "sceneq_tools", *options],
            cwd=folder,
            env=os.environ
            | {"PYTHONPATH": f"{plugin.parent}:{TESTS}", "XDG_RUNTIME_DIR": str(short)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,
        )
        threading.Thread(target=self._read, daemon=True).start()

    def wait_for(self, pattern: str) -> re.Match[str]:
        deadline = time.monotonic() + PATIENCE_S
        while (left_s := deadline - time.monotonic()) > 0:
            try:
                line = self._lines.get(timeout=left_s)
            except queue.Empty:
                break
            if found := re.search(pattern, line):
                return found
        raise AssertionError(f"no {pattern!r} in:\n" + "".join(self.printed))

    def wait_for_pid(self, node: str, verb: str) -> int:
        return int(self.wait_for(rf"{node} +{verb} \(pid (\d+)\)")[1])

    def end(self) -> int:
        code = self.process.wait(PATIENCE_S)
        wait_until(lambda: not any(map(runs, self.pids)))
        return code

    def _read(self) -> None:
        assert self.process.stdout is not None
        with self.process.stdout as stdout:
            for line in stdout:
                self.printed.append(line)
                self.pids.update(int(pid) for pid in re.findall(r"\(pid (\d+)\)", line))
                self._lines.put(line)


def runs(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_until(reached: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not reached():
        assert time.monotonic() < deadline
        time.sleep(0.05)


@pytest.fixture
def port() -> int:
    return free_port()


@pytest.fixture
def short() -> Iterator[Path]:
    """A folder for sockets: pytest's own names are too long for them."""
    with tempfile.TemporaryDirectory(prefix="up-") as folder:
        yield Path(folder)


@pytest.fixture
def start(tmp_path: Path, port: int, short: Path) -> Iterator[Callable[..., Up]]:
    started: list[Up] = []

    def start_up(**options: str) -> Up:
        started.append(Up(tmp_path, port, short, **options))
        return started[-1]

    yield start_up
    for up in started:
        up.process.kill()
        up.end()


def test_a_node_that_was_ready_may_be_killed_more_often_than_a_start_may_fail(
    start: Callable[..., Up],
) -> None:
    up = start()
    pid = up.wait_for_pid("left", "started")
    up.wait_for("all 2 nodes are ready")
    for _ in range(GraphNode.model_fields["max_restarts"].default + 2):
        os.kill(pid, signal.SIGKILL)
        pid = up.wait_for_pid("left", "restarted")
        up.wait_for("left +ready again")
    assert "given up" not in "".join(up.printed)
    os.kill(up.process.pid, signal.SIGINT)
    assert up.end() == 0


def test_what_dies_or_hangs_comes_back_and_ctrl_c_ends_everything(
    start: Callable[..., Up], tmp_path: Path
) -> None:
    up = start()
    left = up.wait_for_pid("left", "started")
    right = up.wait_for_pid("right", "started")
    up.wait_for("all 2 nodes are ready")

    os.kill(left, signal.SIGKILL)
    up.wait_for("left +was ended by SIGKILL")
    left_again = up.wait_for_pid("left", "restarted")
    up.wait_for("left +ready again")
    assert left_again != left
    assert runs(right)
    assert "right        restarted" not in "".join(up.printed)

    os.kill(right, signal.SIGSTOP)
    up.wait_for(r"right +hangs \(no heartbeat for 4 s\): killed")
    up.wait_for("right +ready again")
    assert runs(left_again)

    os.kill(up.process.pid, signal.SIGINT)
    assert up.end() == 0
    assert "INFO left: ready" in (tmp_path / "logs" / "left.log").read_text()


def test_nothing_outlives_a_killed_launcher(start: Callable[..., Up], short: Path) -> None:
    up = start()
    up.wait_for("all 2 nodes are ready")
    up.process.kill()
    assert up.end() == -signal.SIGKILL
    assert len(up.pids) == 3
    wait_until(lambda: not list(short.iterdir()))


def test_a_node_that_refuses_its_input_ends_the_start(start: Callable[..., Up]) -> None:
    up = start(fault="refuse")
    up.wait_for("right +ERROR cannot start: no such recording")
    assert up.end() == 2
    assert not [line for line in up.printed if "restarted" in line]


def test_a_mistake_in_the_graph_is_told_before_anything_starts(start: Callable[..., Up]) -> None:
    up = start(fault="', siz_m: '")
    up.wait_for(
        r"sceneq: graph.yaml:5: nodes.right.params.siz_m: unknown key \(did you mean 'size_m'\?\)"
    )
    assert up.end() == 2
    assert not up.pids


def test_a_port_in_use_is_told_with_a_way_out(start: Callable[..., Up], port: int) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", port))
        taken.listen()
        up = start()
        up.wait_for(rf"sceneq: cannot listen on tcp/127.0.0.1:{port}: .*--port N")
        assert up.end() == 1
