"""The launcher's decisions, with a supervisor and heartbeats from a script."""

import io
import json
import threading
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_schemas.topics import HEALTH
from sceneq_tools import launcher
from sceneq_tools.console import Console
from sceneq_tools.graph import GraphNode, Router, WatchdogLimits
from sceneq_tools.graph_plan import Plan
from sceneq_tools.heartbeats import Heartbeat, heartbeat
from sceneq_tools.supervision import Process

PLAN = Plan(
    scene="room",
    robot="r",
    sensor="s",
    router=Router(listen=["tcp/127.0.0.1:7999"]),
    watchdog=WatchdogLimits(),
    nodes=(GraphNode(id="left"), GraphNode(id="door", kind="routing")),
)
Tick = tuple[dict[str, tuple[str, int]], list[Heartbeat]]


def ready(node: str, pid: int, busy_s: float = 0.0, doing: str = "") -> Heartbeat:
    return Heartbeat(node, pid, True, busy_s, doing)


def states(left: tuple[str, int], door: tuple[str, int] = ("RUNNING", 3)) -> dict[str, tuple]:
    return {"router": ("RUNNING", 1), "left": left, "door": door}


class Script:
    """Stands for supervisor and heartbeats; ends with a stop signal after the last tick."""

    def __init__(self, ticks: list[Tick]) -> None:
        self.ticks = ticks
        self.now: list[Heartbeat] = []
        self.stop = threading.Event()
        self.killed: list[str] = []
        self.held: list[str] = []
        self.revived: list[str] = []
        self.stopped = False

    def start(self) -> None:
        assert not self.stopped

    def alive(self) -> bool:
        return bool(self.ticks)

    def processes(self) -> list[Process]:
        now, self.now = self.ticks.pop(0)
        if not self.ticks:
            self.stop.set()
        return [Process(name, "nodes", state, pid) for name, (state, pid) in now.items()]

    def drain(self) -> list[Heartbeat]:
        return self.now

    def kill(self, process: Process) -> None:
        self.killed.append(process.name)

    def hold(self, process: Process) -> None:
        self.held.append(process.name)

    def revive(self, process: Process) -> None:
        self.revived.append(process.name)

    def close(self) -> None:
        assert not self.stopped

    def stop_all(self) -> None:
        self.stopped = True


Play = Callable[..., tuple[int, list[str], Script]]


@pytest.fixture
def play(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Play:
    def run(*ticks: Tick, reports: str = "") -> tuple[int, list[str], Script]:
        script, stream = Script(list(ticks)), io.StringIO()
        running = type("Running", (), {"stop": lambda _: script.stop_all()})()
        for name in ("start", "alive", "processes", "kill", "hold", "revive"):
            setattr(running, name, getattr(script, name))
        monkeypatch.setattr(launcher, "Supervisor", lambda *_: running)
        monkeypatch.setattr(launcher, "Heartbeats", lambda *_: script)
        monkeypatch.setattr(launcher, "TICK_S", 0.0)
        monkeypatch.setattr(launcher, "run_folder", lambda _: tmp_path)
        up = launcher.Launcher(PLAN, tmp_path / "logs", Console(stream))
        (tmp_path / "logs").mkdir()
        (tmp_path / "logs" / "supervisord.log").write_text(reports)
        code = up.run(script.stop)
        assert script.stopped
        return code, [line[9:] for line in stream.getvalue().splitlines()], script

    return run


def test_a_good_run_is_told_from_start_to_stop(play: Play) -> None:
    running = states(("RUNNING", 2))
    code, told, script = play(
        (running, []),
        (running, [ready("left", 2, doing="playing")]),
        (running, [ready("door", 3), ready("left", 2, doing="playing")]),
    )
    assert code == 0
    assert told[:6] == [
        "up           scene room on tcp/127.0.0.1:7999: left door",
        "router       started (pid 1)",
        "left         started (pid 2)",
        "door         started (pid 3)",
        "left         playing",
        told[5],
    ]
    assert told[5].startswith("up           all 2 nodes are ready after ")
    assert told[6].endswith('sceneq ask "red mug" --connect tcp/127.0.0.1:7999')
    assert told[7].startswith("up           stopped, logs in ")
    assert script.killed == []


def test_a_node_that_refuses_its_parameters_ends_everything(play: Play) -> None:
    code, told, script = play(
        (states(("STARTING", 2)), []),
        (states(("BACKOFF", 0)), []),
        reports="WARN exited: left (exit status 2; not expected)\n",
    )
    assert code == 2
    assert script.held == ["left"]
    assert "left         ended with exit code 2" in told


def test_a_node_that_refuses_later_is_held_and_the_others_live_on(
    play: Play, tmp_path: Path
) -> None:
    logs = tmp_path / "logs" / "supervisord.log"

    class Late(list[Heartbeat]):
        """Writes the report once the node was heard."""

        def __iter__(self):  # type: ignore[no-untyped-def]
            logs.write_text("WARN exited: left (exit status 2; expected)\n")
            return super().__iter__()

    code, told, script = play(
        (states(("RUNNING", 2)), Late([ready("left", 2)])),
        (states(("EXITED", 0)), []),
        (states(("STOPPED", 0)), []),
    )
    assert (code, script.held) == (0, ["left"])
    assert told.count("left         ended with exit code 2") == 1


KILLED = "exited: left (terminated by SIGKILL; not expected)\n"


class Killed(list[Heartbeat]):
    """Writes that ``left`` was killed once its heartbeats were heard."""

    def __init__(self, logs: Path, *beats: Heartbeat) -> None:
        super().__init__(beats)
        self._report = logs / "logs" / "supervisord.log"

    def __iter__(self) -> Iterator[Heartbeat]:
        self._report.write_text(KILLED)
        return super().__iter__()


@pytest.mark.parametrize("state", ["BACKOFF", "FATAL"])
def test_a_ready_node_that_was_killed_does_not_wait(play: Play, tmp_path: Path, state: str) -> None:
    _, told, script = play(
        (states(("STARTING", 2)), Killed(tmp_path, ready("left", 2))),
        (states((state, 0)), []),
        (states(("STARTING", 4)), []),
        (states(("STARTING", 4)), []),
    )
    assert script.revived == ["left"]
    assert "left         restarted (pid 4)" in told
    assert not any("given up" in line for line in told)


def test_a_node_that_was_killed_before_it_was_ready_waits(play: Play, tmp_path: Path) -> None:
    starting = states(("STARTING", 2))
    _, _, script = play((starting, Killed(tmp_path)), (states(("BACKOFF", 0)), []), (starting, []))
    assert script.revived == []


def test_a_node_that_must_not_restart_is_not_revived(
    play: Play, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mortal = GraphNode.model_validate({"id": "left", "restart_policy": "never"})
    monkeypatch.setitem(globals(), "PLAN", replace(PLAN, nodes=(mortal, PLAN.nodes[1])))
    _, _, script = play(
        (states(("STARTING", 2)), Killed(tmp_path, ready("left", 2))),
        (states(("FATAL", 0)), []),
        (states(("FATAL", 0)), []),
    )
    assert script.revived == []


def test_a_node_that_does_nothing_yet_is_not_quoted(play: Play) -> None:
    running = states(("RUNNING", 2))
    beats = [ready("left", 2, doing="playing"), ready("left", 2), ready("left", 2, doing="playing")]
    _, told, _ = play((running, []), (running, beats), (running, []))
    assert [line for line in told if line.startswith("left")] == [
        "left         started (pid 2)",
        "left         playing",
        "left         playing",
    ]


@pytest.mark.parametrize(("status", "code"), [("0; expected", 0), ("1; not expected", 1)])
def test_when_all_nodes_ended_it_is_over(play: Play, status: str, code: int) -> None:
    ended = states(("EXITED", 0), ("EXITED", 0))
    running = states(("RUNNING", 2))
    report = f"exited: left (exit status {status})\n"
    assert play((running, []), (ended, []), (running, []), reports=report)[0] == code


def test_a_node_too_long_in_a_step_is_killed_once(play: Play) -> None:
    running = states(("RUNNING", 2))
    late = ready("left", 2, busy_s=61.0)
    _, told, script = play((running, []), (running, [late]), (running, []))
    assert script.killed == ["left"]
    assert "left         hangs (61 s inside one step): killed" in told


def test_the_last_words_of_a_dead_process_are_no_heartbeat(play: Play) -> None:
    running = states(("RUNNING", 2))
    _, _, script = play((running, []), (running, [ready("left", 99, busy_s=99.0)]), (running, []))
    assert script.killed == []


def test_a_health_message_is_a_heartbeat() -> None:
    health = {"pid": 7, "state": "ready", "busy_s": 1.5, "values": {"state": "playing"}}
    beat = heartbeat(HEALTH.key(node="left"), json.dumps(health).encode())
    assert beat == Heartbeat("left", 7, True, 1.5, "playing")


@given(st.binary(max_size=40) | st.text(max_size=40).map(str.encode))
def test_junk_is_no_heartbeat(payload: bytes) -> None:
    assert heartbeat(HEALTH.key(node="left"), payload) is None
    assert heartbeat("sceneq/health/a/b", b'{"pid": 1, "state": "ready"}') is None


@pytest.mark.parametrize(
    "body", [b"[]", b"3", b"null", b'{"pid": []}', b'{"pid": 1e999, "state": 0}', b'{"pid": 3}']
)
def test_the_wrong_json_is_no_heartbeat(body: bytes) -> None:
    assert heartbeat(HEALTH.key(node="left"), body) is None
