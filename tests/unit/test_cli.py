"""The command line: what is printed where, and with which exit code."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._client import Client
from sceneq_schemas.topics import HEALTH, TOPICS
from sceneq_tools import cli, scenes, status
from sceneq_tools.up_command import source_overrides

ANSWER = {
    "status": "found",
    "question": "red mug",
    "instances": [
        {
            "id": 12,
            "label": "cup",
            "label_p": 0.31,
            "p": 0.72,
            "cosine": 0.412,
            "centre": [1.0, -0.25, 0.8],
            "box_oriented": {"size": [0.1, 0.08, 0.1]},
            "views": [{"seq": 30}, {"seq": 70}],
        }
    ],
    "confidence": {"p_max": 0.72, "margin": 0.4, "entropy_norm": 0.2, "T": 0.05},
    "route": "fast",
    "reason": "clear",
    "cost": {"vlm_calls": 0, "ms": {"text": 3.1}},
    "map": {"epoch": 5, "seq": 40, "age_s": 0.2},
    "took_ms": 3.4,
}
Result = tuple[list[tuple[str, Reply]], list[QueryError]]
Outcome = tuple[int, str, str]


def reply(key: str, body: Any) -> tuple[str, Reply]:
    return key, Reply(json.dumps(body).encode(), "application/json")


class FakeClient:
    """Answers from a script; the last answer of a key repeats."""

    def __init__(self, script: dict[str, list[Result]], heartbeats: dict[str, Any]) -> None:
        self.script = script
        self.heartbeats = heartbeats
        self.asked: list[tuple[str, Any]] = []

    def __enter__(self) -> "FakeClient":
        return self

    def __exit__(self, *_: object) -> None:
        self.script = {}

    def get(
        self, selector: str, payload: bytes = b"", encoding: str = "", timeout_s: float = 0.0
    ) -> Result:
        self.asked.append((selector, json.loads(payload) if payload else None))
        results = self.script.get(selector, [([], [])])
        return results.pop(0) if len(results) > 1 else results[0]

    def subscribe(self, selector: str, callback: Callable[[str, str, bytes], None]) -> None:
        assert selector == HEALTH.selector()
        for node, health in self.heartbeats.items():
            callback(HEALTH.key(node=node), "application/json", json.dumps(health).encode())

    def alive(self) -> list[dict[str, str]]:
        return [{"node": "mapping", "id": "7"}, {"node": "views", "id": "8"}]


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Outcome]:
    def run_sceneq(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["sceneq", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        out, err = capsys.readouterr()
        return int(ended.value.code or 0), out, err

    return run_sceneq


@pytest.fixture
def bus(monkeypatch: pytest.MonkeyPatch) -> FakeClient:
    client = FakeClient(
        {
            "sceneq/query/*/status": [
                ([reply("sceneq/query/room/status", {"instances": 9, "alive": ["mapping"]})], [])
            ],
            "sceneq/query/room/ask": [([reply("sceneq/query/room/ask", ANSWER)], [])],
        },
        {},
    )
    monkeypatch.setattr(scenes, "Client", lambda endpoint: client)
    monkeypatch.setattr(status, "LISTEN_S", 0.0)
    monkeypatch.setattr(status, "PATIENCE_S", 0.0)
    return client


def test_version_and_help(run: Callable[..., Outcome]) -> None:
    assert run("--version")[1].startswith("sceneq 0.")
    code, out, _ = run("--help")
    assert code == 0
    assert all(name in out for name in ("up", "ask", "status", "check", "schema"))
    assert run()[0] == 2


def test_help_loads_nothing_heavy() -> None:
    heavy = ("numpy", "zenoh", "pydantic", "yaml", "torch", "cv2", "open3d")
    probe = f"import sys, sceneq_tools.cli; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "arguments",
    [
        ("bogus",),
        ("ask",),
        ("up", "--port", "many"),
        ("ask", "mug", "--mode", "slow"),
        ("ask", " "),
    ],
)
def test_wrong_usage_is_one_line(run: Callable[..., Outcome], arguments: tuple[str, ...]) -> None:
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith("sceneq: ")
    assert err.count("\n") == 1


def test_schema_lists_every_topic(run: Callable[..., Outcome]) -> None:
    rows = json.loads(run("schema", "--json")[1])
    assert [row["key"] for row in rows] == [topic.pattern for topic in TOPICS]
    assert rows[0]["message"] == "Frame"
    table = run("schema")[1]
    assert all(topic.pattern in table for topic in TOPICS)


def test_an_answer_is_a_table_with_route_confidence_and_time(
    run: Callable[..., Outcome], bus: FakeClient
) -> None:
    code, out, err = run("ask", "red mug", "-k", "3")
    assert (code, err) == (0, "")
    assert bus.asked[-1] == ("sceneq/query/room/ask", {"q": "red mug", "k": 3})
    assert "found: 'red mug' by the fast route (clear)" in out
    row = next(line for line in out.splitlines() if "cup" in line)
    assert " ".join(row.split()) == "12 cup 0.72 0.412 1.00 -0.25 0.80 0.10 0.08 0.10 30 70"
    assert "confidence: p_max 0.72  margin 0.4  entropy_norm 0.2  T 0.05" in out
    assert "ms: total 3.4  text 3.1" in out
    assert "scene room" in out


def test_an_answer_as_json_is_the_answer(run: Callable[..., Outcome], bus: FakeClient) -> None:
    assert json.loads(run("ask", "red mug", "--json")[1]) == ANSWER


def test_the_mode_chooses_the_key(run: Callable[..., Outcome], bus: FakeClient) -> None:
    bus.script["sceneq/query/room/instances"] = bus.script["sceneq/query/room/ask"]
    run("ask", "mug", "--mode", "fast")
    run("ask", "mug", "--mode", "reason", "--scene", "room")
    assert [(key, request) for key, request in bus.asked if request] == [
        ("sceneq/query/room/instances", {"q": "mug", "k": 5}),
        ("sceneq/query/room/ask", {"q": "mug", "k": 5, "mode": "reason"}),
    ]


def test_a_busy_scene_is_asked_again(run: Callable[..., Outcome], bus: FakeClient) -> None:
    busy: Result = ([], [QueryError("busy", "full", "", 1)])
    bus.script["sceneq/query/room/ask"][:0] = [busy, busy]
    assert run("ask", "mug")[0] == 0
    for_long: Result = ([], [QueryError("busy", "full", "", 120_000)])
    bus.script = {"sceneq/query/room/ask": [for_long]}
    code, _, err = run("ask", "mug", "--scene", "room")
    assert (code, err) == (1, "sceneq: busy: full\n")


@pytest.mark.parametrize(
    ("result", "code", "told"),
    [
        (([], []), 1, "nobody answers for scene 'room' (see: sceneq status)"),
        (([], [QueryError("timeout", "Timeout")]), 1, "scene 'room' did not answer within 60 s"),
        (
            ([], [QueryError("bad_request", "no question", "add ?q=")]),
            2,
            "bad_request: no question (add ?q=)",
        ),
        (([("k", Reply(b"\x81", ""))], []), 1, "the answer is not JSON"),
        (([("k", Reply(b"[1]", ""))], []), 1, "the answer is not a JSON object: [1]"),
    ],
)
def test_no_answer_is_one_line(
    run: Callable[..., Outcome], bus: FakeClient, result: Result, code: int, told: str
) -> None:
    bus.script["sceneq/query/room/ask"] = [result]
    got, out, err = run("ask", "mug")
    assert (got, out) == (code, "")
    assert err.startswith(f"sceneq: {told}")
    assert err.count("\n") == 1


def test_the_scene_has_to_be_clear(run: Callable[..., Outcome], bus: FakeClient) -> None:
    two = [reply(f"sceneq/query/{scene}/status", {}) for scene in ("room", "hall")]
    bus.script["sceneq/query/*/status"] = [(two, [])]
    assert run("ask", "mug") == (
        2, "", "sceneq: several scenes answer: hall, room (say which with --scene)\n"
    )  # fmt: skip
    bus.script = {}
    assert run("ask", "mug")[2].startswith("sceneq: no scene answers (start one: sceneq up")
    assert run("ask", "mug", "--scene", "My Room")[0] == 2


def test_without_a_router_the_hint_says_how_to_start_one(
    run: Callable[..., Outcome], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(endpoint: str) -> Client:
        raise ConnectionError(endpoint)

    monkeypatch.setattr(scenes, "Client", refuse)
    code, _, err = run("ask", "mug", "--connect", "tcp/far:1")
    assert code == 1
    assert err.startswith("sceneq: no router at tcp/far:1 (start one: sceneq up --source FOLDER")


def test_status_shows_nodes_and_scenes(run: Callable[..., Outcome], bus: FakeClient) -> None:
    bus.heartbeats["mapping"] = {
        "kind": "mapping",
        "state": "ready",
        "pid": 7,
        "uptime_s": 12.34,
        "rss_mb": 80.5,
        "inbox": {"a": 2},
        "topics": {
            "mask": {"in": 5, "dropped": 1, "age_ms": 400},
            "map_delta": {"out": 4, "age_ms": 900},
        },
        "counters": {"masks_late": 3},
        "values": {"instances": 9},
    }
    code, out, _ = run("status")
    assert code == 0
    rows = [line.split() for line in out.splitlines()]
    assert ["mapping", "ready", "7", "12.3", "0.4", "80.5", "5", "4", "1", "0", "2"] in rows
    assert "mapping: instances=9 masks_late=3" in out
    assert ["views", "silent", "8"] in [row[:3] for row in rows]
    assert "scene room: instances=9 alive=1" in out
    told = json.loads(run("status", "--json")[1])
    assert [node["node"] for node in told["nodes"]] == ["mapping", "views"]


def test_an_empty_router_is_no_graph(run: Callable[..., Outcome], bus: FakeClient) -> None:
    bus.script = {}
    bus.alive = list  # type: ignore[method-assign]
    code, _, err = run("status", "--connect", "tcp/here:1")
    assert code == 1
    assert err.startswith("sceneq: a router is at tcp/here:1, but no node")


def test_options_about_the_source_go_over_the_graph(tmp_path: Path) -> None:
    (tmp_path / "frame-000000.color.png").touch()
    given = source_overrides(tmp_path, "room", 30.0, 2, True, True, "files")
    assert [(o.kind, *o.path, o.value, o.option) for o in given] == [
        ("", "scene", "room", "--scene"),
        ("ingest", "source", "kind", "folder", "--source"),
        ("ingest", "source", "path", str(tmp_path), "--source"),
        ("ingest", "source", "step", 2, "--step"),
        ("ingest", "source", "loop", True, "--loop"),
        ("ingest", "source", "use_poses", False, "--no-poses"),
        ("ingest", "rate_hz", 30.0, "--rate"),
        ("segmentation", "segmenter", {"kind": "files", "path": str(tmp_path)}, "--segmenter"),
    ]
    assert source_overrides(None, None, None, None, False, False, None) == []
    assert source_overrides(None, None, 0.0, None, False, False, None)[0].value == 0.0
