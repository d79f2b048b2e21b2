"""Real processes on a real router: what arrives, what is refused, and how a process ends."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

from sceneq_nodes._bus import QueryError
from sceneq_nodes._client import Client
from sceneq_nodes._queries import SLOTS
from sceneq_schemas.codec import decode, encode
from sceneq_schemas.frame import Pose
from sceneq_schemas.topics import HEALTH, METRIC, POSE

from support.live_graph import free_port

pytestmark = pytest.mark.integration

TOY = str(Path(__file__).parents[1] / "support" / "toy_node.py")
PATIENCE_S = 60.0
KEY = "sceneq/query/room/instances"
T = TypeVar("T")


@dataclass
class Graph:
    """A router on a port of its own and the processes started beside it."""

    endpoint: str
    processes: list[subprocess.Popen[bytes]]
    folder: Path

    def start(self, *command: str, **environment: str) -> subprocess.Popen[bytes]:
        log = (self.folder / f"{len(self.processes)}.log").open("wb")
        with log:
            process = subprocess.Popen(
                [sys.executable, *command], stderr=log, env=os.environ | environment
            )
        self.processes.append(process)
        return process

    def start_router(self) -> subprocess.Popen[bytes]:
        return self.start("-m", "sceneq_nodes", "router", "--endpoint", self.endpoint)

    def start_toy(self, *arguments: str, node: str = "toy") -> subprocess.Popen[bytes]:
        names = ("--scene", "room", "--robot", "r1", "--node", node)
        return self.start(TOY, "toy", "--endpoint", self.endpoint, *names, *arguments)

    def log(self, process: subprocess.Popen[bytes]) -> str:
        return (self.folder / f"{self.processes.index(process)}.log").read_text()


def free_endpoint() -> str:
    return f"tcp/127.0.0.1:{free_port()}"


def until(look: Callable[[], T], what: str) -> T:
    """Return the first true value of ``look``; fail when there is none for a generous while."""
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        if value := look():
            return value
        time.sleep(0.05)
    raise AssertionError(f"waited {PATIENCE_S} s for {what}")


def pose(seq: int, source: str = "given") -> bytes:
    return encode(Pose(seq, seq, np.eye(4), source, False))


def send(client: Client, seq: int, source: str = "given") -> None:
    client.publish(POSE.key(robot="r1"), pose(seq, source), POSE.encoding)


def ask(client: Client, text: str = "", payload: bytes = b"", encoding: str = "") -> Any:
    replies, errors = client.get(KEY + text, payload, encoding)
    if errors:
        raise errors[0]
    return json.loads(replies[0][1].payload) if replies else None


def answers(client: Client) -> bool:
    """Whether there is an answer; the way to it may be lost while it is asked for."""
    with contextlib.suppress(QueryError):
        return ask(client) is not None
    return False


def nodes(client: Client) -> set[str]:
    return {token["node"] for token in client.alive()}


class Heard:
    """The newest health and metrics message of every node."""

    def __init__(self, client: Client) -> None:
        self.health: dict[str, dict[str, Any]] = {}
        self.metrics: dict[str, dict[str, Any]] = {}
        client.subscribe(HEALTH.selector(), self._on_health)
        client.subscribe(METRIC.selector(), self._on_metrics)

    def _on_health(self, key: str, encoding: str, payload: bytes) -> None:
        assert encoding == HEALTH.encoding
        self.health[key.rpartition("/")[2]] = json.loads(payload)

    def _on_metrics(self, key: str, encoding: str, payload: bytes) -> None:
        self.metrics[key.rpartition("/")[2]] = json.loads(payload)["metrics"]


@contextlib.contextmanager
def running(folder: Path) -> Iterator[Graph]:
    graph = Graph(free_endpoint(), [], folder)
    try:
        graph.start_router()
        yield graph
    finally:
        for process in graph.processes:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def graph(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Graph]:
    with running(tmp_path_factory.mktemp("graph")) as graph:
        yield graph


@pytest.fixture(scope="module")
def client(graph: Graph) -> Iterator[Client]:
    with Client(graph.endpoint, timeout_s=PATIENCE_S) as client:
        yield client


@pytest.fixture
def toy(graph: Graph, client: Client) -> Iterator[subprocess.Popen[bytes]]:
    process = graph.start_toy()
    until(lambda: "toy" in nodes(client), "the toy node")
    yield process
    process.kill()
    process.wait()
    until(lambda: "toy" not in nodes(client), "the toy's token to vanish")


def test_messages_come_through_in_order(client: Client, toy: subprocess.Popen[bytes]) -> None:
    echoed: list[int] = []
    client.subscribe(
        POSE.key(robot="echo"), lambda _k, _e, data: echoed.append(decode(Pose, data).seq)
    )
    until(lambda: send(client, 0) or echoed, "the first echo")
    for seq in range(1, 6):
        send(client, seq)
        until(lambda seq=seq: seq in echoed, f"pose {seq}")
    assert [seq for seq in echoed if seq] == [1, 2, 3, 4, 5]


def test_health_counts_what_came_and_what_did_not_decode(
    graph: Graph, client: Client, toy: subprocess.Popen[bytes]
) -> None:
    heard = Heard(client)
    send(client, 7)
    client.publish(POSE.key(robot="r1"), b"\xc1", POSE.encoding)
    client.publish(POSE.key(robot="r1"), pose(8), "application/msgpack;sceneq.pose.v2")
    client.publish(POSE.key(robot="r1"), b"x" * (POSE.max_bytes + 1), POSE.encoding)
    health = until(
        lambda: (h := heard.health.get("toy")) and "idle" in h["counters"] and
        h["topics"].get("pose", {}).get("undecodable") == 3 and h["busy_s"] == 0.0 and h,
        "three undecodable messages in the health message of an idle node",
    )  # fmt: skip
    assert health["kind"] == "toy"
    assert health["pid"] == toy.pid
    assert health["state"] == "ready"
    assert health["values"] == {"seq": 7}
    assert health["topics"]["pose"]["in"] == 1
    assert health["topics"]["pose"]["out"] == 1
    assert health["topics"]["pose"]["age_ms"] >= 0
    assert health["inbox"] == {"sceneq/pose/r1/v1": 0}
    assert health["rss_mb"] > 1
    until(lambda: heard.metrics.get("toy", {}).get("pose.undecodable") == 3, "the metrics")
    until(lambda: "undecodable no. 1 on sceneq/pose/r1/v1" in graph.log(toy), "the log")
    assert toy.poll() is None


def test_a_query_gets_parameters_payload_and_the_wildcard_flag(
    client: Client, toy: subprocess.Popen[bytes]
) -> None:
    answer = ask(client, "?q=red%20mug%3B next;k=5;q=second", b"also this", "text/plain")
    assert answer == {
        "parameters": {"q": "red mug; next", "k": "5"},
        "wildcard": False,
        "payload": "also this",
        "encoding": "text/plain",
    }
    replies, errors = client.get("sceneq/query/**")
    assert errors == []
    assert [key for key, _ in replies] == [KEY]
    assert json.loads(replies[0][1].payload)["wildcard"] is True


def test_refusals_and_bugs_are_told_apart(client: Client, toy: subprocess.Popen[bytes]) -> None:
    _, refused = client.get(f"{KEY}?do=refuse")
    assert [(e.code, e.message, e.hint) for e in refused] == [
        ("bad_request", "no question", "add ?q=")
    ]
    _, failed = client.get(f"{KEY}?do=fail")
    assert [(e.code, e.message) for e in failed] == [("internal", "RuntimeError: broken")]
    _, too_large = client.get(KEY, b"x" * (1024 * 1024 + 1))
    assert [e.code for e in too_large] == ["too_large"]
    assert client.get(f"{KEY}?do=nothing") == ([], [])
    assert ask(client)["parameters"] == {}


def test_more_queries_than_slots_are_refused_at_once(
    client: Client, toy: subprocess.Popen[bytes]
) -> None:
    many = SLOTS + 28
    with ThreadPoolExecutor(many) as pool:
        wait = partial(client.get, f"{KEY}?do=wait", timeout_s=PATIENCE_S)
        asked = [pool.submit(wait) for _ in range(many)]
        until(lambda: sum(one.done() for one in asked) == many - SLOTS, "the refusals")
        until(lambda: send(client, 1, "release") or all(one.done() for one in asked), "answers")
    results = [one.result() for one in asked]
    refused = [error for _, errors in results for error in errors]
    assert sum(len(replies) for replies, _ in results) == SLOTS
    assert [(e.code, e.retry_ms) for e in refused] == [("busy", 200)] * (many - SLOTS)
    assert ask(client)["parameters"] == {}


def test_nodes_see_who_is_alive(client: Client, toy: subprocess.Popen[bytes]) -> None:
    assert ask(client, "?do=alive") == {"alive": ["toy"]}


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_a_node_in_order(
    graph: Graph, client: Client, toy: subprocess.Popen[bytes], number: int
) -> None:
    toy.send_signal(number)
    assert toy.wait(PATIENCE_S) == 0
    assert graph.log(toy).endswith("closed\n")
    until(lambda: "toy" not in nodes(client), "the token to vanish")


@pytest.mark.parametrize("act", ["sleep", "compute"])
def test_a_signal_ends_a_node_that_never_returns(
    graph: Graph, client: Client, toy: subprocess.Popen[bytes], act: str
) -> None:
    heard = Heard(client)
    send(client, 1, act)
    until(lambda: heard.health.get("toy", {}).get("busy_s", 0.0) > 0, "a health message: busy")
    for seq in range(10):
        send(client, seq)
    until(lambda: heard.health["toy"]["topics"]["pose"].get("dropped") == 6, "what is too much")
    assert heard.health["toy"]["inbox"] == {"sceneq/pose/r1/v1": 4}
    toy.terminate()
    assert toy.wait(PATIENCE_S) == 0
    assert "still at work" in graph.log(toy)


def test_a_killed_node_comes_back(graph: Graph, client: Client) -> None:
    first = graph.start_toy(node="phoenix")
    until(lambda: "phoenix" in nodes(client), "the node")
    first.kill()
    until(lambda: "phoenix" not in nodes(client), "the token to vanish")
    assert client.get(KEY) == ([], [])
    second = graph.start_toy(node="phoenix")
    until(lambda: "phoenix" in nodes(client), "the node again")
    assert ask(client)["wildcard"] is False
    second.terminate()
    assert second.wait(PATIENCE_S) == 0


def test_a_bug_in_a_step_ends_the_node_with_1(
    graph: Graph, client: Client, toy: subprocess.Popen[bytes]
) -> None:
    send(client, 12, "crash")
    assert toy.wait(PATIENCE_S) == 1
    log = graph.log(toy)
    assert "step failed on sceneq/pose/r1/v1 seq 12" in log
    assert "RuntimeError: a bug" in log


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--param", "dept=3"), "sceneq: dept: unknown key (did you mean 'depth'?)\n"),
        (("--param", "depth=much"), "sceneq: depth: Input should be a valid integer"),
        (("--param", "missing=/nowhere"), "cannot start: no such folder: /nowhere\n"),
    ],
)
def test_bad_input_is_told_and_ends_with_2(
    graph: Graph, arguments: tuple[str, ...], says: str
) -> None:
    process = graph.start_toy(*arguments, node="bad")
    assert process.wait(PATIENCE_S) == 2
    log = graph.log(process).splitlines(keepends=True)
    assert says in log[-1]
    assert "Traceback" not in "".join(log)


def test_two_routers_cannot_share_a_port(graph: Graph, client: Client) -> None:
    second = graph.start_router()
    assert second.wait(PATIENCE_S) == 2
    assert graph.log(second) == f"sceneq: cannot listen on {graph.endpoint}: the port is in use\n"


def test_nobody_listens() -> None:
    endpoint = free_endpoint()
    with pytest.raises(ConnectionError, match=f"no router at {endpoint}"):
        Client(endpoint, timeout_s=0.3)


def test_nodes_wait_for_the_router_and_outlive_it(tmp_path: Path) -> None:
    with running(tmp_path) as graph:
        toy = graph.start_toy()
        with Client(graph.endpoint, timeout_s=PATIENCE_S) as client:
            until(lambda: answers(client), "an answer")
            graph.processes[0].kill()
            graph.processes[0].wait()
            graph.start_router()
            until(lambda: answers(client), "an answer through the new router")
        assert toy.poll() is None


def test_a_node_stops_while_it_waits_for_a_router(tmp_path: Path) -> None:
    graph = Graph(free_endpoint(), [], tmp_path)
    toy = graph.start_toy()
    try:
        until(lambda: "connecting to tcp/" in graph.log(toy), "the node to try")
        time.sleep(0.3)
        toy.terminate()
        assert toy.wait(PATIENCE_S) == 0
    finally:
        toy.kill()


def test_the_launchers_file_says_it_all(graph: Graph, client: Client, tmp_path: Path) -> None:
    plan = {
        "scene": "room",
        "robot": "r1",
        "sensor": "cam",
        "router": {"endpoint": graph.endpoint, "listen": [graph.endpoint], "connect": []},
        "nodes": {"second": {"kind": "toy", "params": {"depth": 2}}},
    }
    path = tmp_path / "graph.json"
    path.write_text(json.dumps(plan))
    process = graph.start(TOY, SCENEQ_GRAPH=str(path), SCENEQ_NODE="second")
    until(lambda: "second" in nodes(client), "the node of the file")
    process.terminate()
    assert process.wait(PATIENCE_S) == 0
    unknown = graph.start(TOY, SCENEQ_GRAPH=str(path), SCENEQ_NODE="secon")
    assert unknown.wait(PATIENCE_S) == 2
    assert "nodes.secon: no such node (did you mean 'second'?)" in graph.log(unknown)
