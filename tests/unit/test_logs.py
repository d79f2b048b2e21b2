"""Logs as JSON: one object a line, with the message or the question that it is about."""

import io
import json
import logging
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace

import pytest

from sceneq_nodes._logs import (
    JsonLines,
    TextLines,
    about_message,
    about_query,
    query_attachment,
    set_up_logs,
)
from sceneq_tools.graph import load
from sceneq_tools.graph_plan import plan
from sceneq_tools.graph_problem import GraphError

log = logging.getLogger("sceneq_nodes.mapping")


@pytest.fixture
def written() -> Iterator[io.StringIO]:
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    handler.setFormatter(JsonLines("mapping", "room"))
    log.addHandler(handler)
    log.setLevel(logging.INFO)
    yield stream
    log.removeHandler(handler)


def test_a_record_is_one_object_with_who_and_when(written: io.StringIO) -> None:
    log.warning("frame %d refused:\n%s", 7, "no \U0001f4f7 pinhole")
    (line,) = written.getvalue().splitlines()
    told = json.loads(line)
    assert told.pop("time").endswith("+00:00")
    assert told == {
        "level": "WARNING",
        "node": "mapping",
        "scene": "room",
        "logger": "sceneq_nodes.mapping",
        "message": "frame 7 refused:\nno \U0001f4f7 pinhole",
    }


def test_it_says_which_message_or_question_it_is_about(written: io.StringIO) -> None:
    with about_message(SimpleNamespace(seq=41)):
        log.info("one")
    with about_query(b"00ff00ff"):
        log.info("two")
        assert query_attachment() == b"00ff00ff"
    with about_message(None):
        log.info("three")
    one, two, three = map(json.loads, written.getvalue().splitlines())
    assert one["seq"] == 41
    assert "query" not in one
    assert two["query"] == "00ff00ff"
    assert "seq" not in two
    assert "seq" not in three
    assert query_attachment() is None


@pytest.mark.parametrize("attachment", [None, b"", b"\xff" * 8, b"short", b"f" * 33, b"../../etc"])
def test_a_question_without_a_proper_id_gets_a_new_one(attachment: bytes | None) -> None:
    with about_query(attachment):
        first = query_attachment()
    with about_query(attachment):
        second = query_attachment()
    assert first is not None
    assert second is not None
    assert len(first) == len(second) == 8
    assert first != second


def test_an_exception_is_told_with_its_traceback(written: io.StringIO) -> None:
    try:
        raise KeyError("voxel")
    except KeyError:
        log.exception("step failed")
    (line,) = written.getvalue().splitlines()
    told = json.loads(line)
    assert told["message"] == "step failed"
    assert told["error"].endswith("KeyError: 'voxel'")


def test_what_a_stranger_said_is_cut(written: io.StringIO) -> None:
    log.info("x" * 100_000)
    assert len(json.loads(written.getvalue())["message"]) == 4_000


def test_the_form_is_chosen_by_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    root = logging.getLogger()
    monkeypatch.setattr(root, "handlers", list(root.handlers))
    monkeypatch.setattr(root, "level", root.level)
    for environment, formatter in (
        ({}, TextLines),
        ({"SCENEQ_LOG": ""}, TextLines),
        ({"SCENEQ_LOG": "json"}, JsonLines),
    ):
        root.handlers = []
        set_up_logs("mapping", "room", environment)
        assert type(root.handlers[-1].formatter) is formatter
        assert root.handlers[-1].stream is sys.stderr
    with pytest.raises(ValueError, match="SCENEQ_LOG: 'xml', known: text, json"):
        set_up_logs("mapping", "room", {"SCENEQ_LOG": "xml"})


def test_the_graph_says_the_form(tmp_path: Path) -> None:
    path = tmp_path / "graph.yaml"
    path.write_text("scene: room\nlog: json\nnodes: [{id: mapping}]")
    assert plan(*load(path), "local").log == "json"
    path.write_text("scene: room\nnodes: [{id: mapping}]")
    assert plan(*load(path), "local").log == "text"
    path.write_text("scene: room\nlog: xml\nnodes: [{id: mapping}]")
    with pytest.raises(GraphError, match="log"):
        load(path)
