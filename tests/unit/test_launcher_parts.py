"""The parts of the launcher that need no processes."""

import configparser
import io
import sys
from pathlib import Path

import pytest

from sceneq_tools.console import Console
from sceneq_tools.graph import GraphNode
from sceneq_tools.log_tail import LogTail, last_line
from sceneq_tools.story import Exit, change, exit_in
from sceneq_tools.supervision import Process
from sceneq_tools.supervisor_config import render
from sceneq_tools.troubles import Troubles


def parsed(*nodes: GraphNode, folder: str = "/run/x") -> configparser.ConfigParser:
    conf = configparser.ConfigParser(interpolation=None)
    conf.read_string(render(nodes, Path(folder), Path("/logs")))
    return conf


def test_every_node_is_a_program_and_the_router_comes_first() -> None:
    conf = parsed(GraphNode(id="left"), GraphNode(id="right", kind="left"))
    programs = [name for name in conf.sections() if name.startswith("program:")]
    assert programs == ["program:router", "program:left", "program:right"]
    assert conf["group:nodes"]["programs"] == "left,right"
    assert conf["program:left"]["command"] == f"{sys.executable} -P -m sceneq_nodes"
    assert conf["program:router"]["command"].endswith("sceneq_nodes router")
    assert conf["program:left"]["environment"] == 'SCENEQ_NODE="left"'
    assert conf["program:left"]["stdout_logfile"] == "/logs/left.log"


@pytest.mark.parametrize(
    ("policy", "autorestart", "retries"),
    [("on-failure", "unexpected", "3"), ("always", "true", "3"), ("never", "false", "0")],
)
def test_the_restart_policy_reaches_the_supervisor(
    policy: str, autorestart: str, retries: str
) -> None:
    node = GraphNode.model_validate({"id": "a", "restart_policy": policy, "max_restarts": 3})
    program = parsed(node)["program:a"]
    assert program["autorestart"] == autorestart
    assert program["startretries"] == retries
    assert program["exitcodes"] == "0,2"


def test_a_percent_sign_in_a_path_is_not_expanded() -> None:
    assert parsed(folder="/run/50%")["unix_http_server"]["file"] == "/run/50%%/supervisor.sock"


def test_without_nodes_there_is_no_group() -> None:
    assert "group:nodes" not in parsed()


@pytest.mark.parametrize(
    ("line", "end", "words"),
    [
        ("WARN exited: a (exit status 2; not expected)", Exit("a", 2), "ended with exit code 2"),
        ("INFO exited: a (exit status 0; expected)", Exit("a", 0), "finished"),
        (
            "WARN exited: b-1 (terminated by SIGKILL; not expected)",
            Exit("b-1", -1, "SIGKILL"),
            "was ended by SIGKILL",
        ),
    ],
)
def test_exits_are_read_from_the_log_of_the_supervisor(line: str, end: Exit, words: str) -> None:
    assert exit_in(f"2026-11-22 05:27:51,212 {line}") == end
    assert str(end) == words


def test_what_nobody_asked_for_is_not_an_exit_when_it_was_asked_for() -> None:
    assert exit_in("INFO stopped: a (exit status 0)") is None


def process(state: str, pid: int) -> Process:
    return Process("a", "nodes", state, pid)


def test_the_story_of_a_process() -> None:
    assert change(None, process("STARTING", 7)) == ("started (pid 7)", "")
    assert change(process("STARTING", 7), process("RUNNING", 7)) is None
    assert change(process("RUNNING", 7), process("STARTING", 8)) == ("restarted (pid 8)", "warn")
    assert change(process("RUNNING", 7), process("BACKOFF", 0)) is None
    assert change(process("BACKOFF", 0), process("STARTING", 9)) == ("restarted (pid 9)", "warn")
    gone = change(process("BACKOFF", 0), process("FATAL", 0))
    assert gone == ("failed to start too often, given up", "bad")
    assert change(process("FATAL", 0), process("FATAL", 0)) is None


def test_a_tail_shows_only_what_is_new_and_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text("old\n")
    tail = LogTail(path)
    with path.open("a") as log:
        log.write("one\ntw")
    assert tail.new_lines() == ["one"]
    with path.open("a") as log:
        log.write("o\n")
    assert tail.new_lines() == ["two"]
    assert tail.new_lines() == []
    tail.close()


def test_a_tail_follows_through_rotation_and_late_birth(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    tail = LogTail(path)
    assert tail.new_lines() == []
    path.write_text("first\n")
    assert tail.new_lines() == ["first"]
    with path.open("a") as log:
        log.write("last of the old\n")
    path.rename(tmp_path / "a.log.1")
    path.write_bytes(b"first of the new\nnot \xff text\n")
    assert tail.new_lines() == ["last of the old", "first of the new", "not � text"]
    tail.close()


def test_the_last_line_is_the_last_with_text(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    assert last_line(path) == ""
    path.write_text("Traceback\n  deep\nRuntimeError: a bug\n\n")
    assert last_line(path) == "RuntimeError: a bug"


def test_warnings_are_forwarded_without_flooding(tmp_path: Path) -> None:
    stream = io.StringIO()
    troubles = Troubles(tmp_path, ["views"], Console(stream))
    lines = [f"2026-11-22 05:45:20,1 WARNING views: frame {n}: skipped\n" for n in range(100, 106)]
    (tmp_path / "views.log").write_text(
        "2026-11-22 05:45:19,1 INFO views: ready\n" + "".join(lines) + "x ERROR views: lost\n"
    )
    troubles.forward()
    troubles.close()
    assert [line[22:] for line in stream.getvalue().splitlines()] == [
        "WARNING frame 100: skipped",
        "WARNING frame 101: skipped (2 like this)",
        "WARNING frame 103: skipped (4 like this)",
        "ERROR lost",
    ]


def test_an_event_is_one_line_without_colours_off_a_terminal() -> None:
    stream = io.StringIO()
    Console(stream).say("mapping", "two\nlines", "bad")
    assert stream.getvalue().endswith(" mapping      two lines\n")
    assert stream.getvalue().count("\n") == 1


def test_warnings_in_json_are_forwarded_too(tmp_path: Path) -> None:
    stream = io.StringIO()
    troubles = Troubles(tmp_path, ["views"], Console(stream))
    (tmp_path / "views.log").write_text(
        '{"level": "INFO", "message": "ready"}\n'
        '{"level": "WARNING", "node": "views", "message": "frame 7: skipped", "seq": 7}\n'
        '{"level": "ERROR", "message": "step failed", "error": "Traceback\\nKeyError: 3"}\n'
        "{ no object\n"
    )
    troubles.forward()
    troubles.close()
    assert [line[22:] for line in stream.getvalue().splitlines()] == [
        "WARNING frame 7: skipped",
        "ERROR step failed: KeyError: 3",
    ]
