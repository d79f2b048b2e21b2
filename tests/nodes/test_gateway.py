"""The gateway over HTTP and WebSocket: a real server, the routing node behind a fake bus."""

import json
import ssl
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import httpx2
import jsonschema
import numpy as np
import pytest
import schemathesis
from hypothesis import given, settings
from schemathesis.specs.openapi.checks import positive_data_acceptance
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from sceneq_nodes._backends import BACKENDS
from sceneq_nodes._bus import QueryError, Received, Reply
from sceneq_nodes._counters import Counters
from sceneq_nodes._health import Health
from sceneq_nodes.gateway import TOKEN_VARIABLE, Gateway
from sceneq_nodes.web.app import Pages, application
from sceneq_nodes.web.desk import Desk
from sceneq_nodes.web.events import MAX_WAITING, Hub
from sceneq_nodes.web.guard import LOOPBACK, Access
from sceneq_nodes.web.openapi import document
from sceneq_nodes.web.server import TlsParams, WebServer
from sceneq_schemas.answer import ANSWER
from sceneq_schemas.topics import (
    HEALTH,
    MAP_DELTA,
    QUERY_ASK,
    QUERY_INSTANCES,
    QUERY_LABEL,
    QUERY_LABELS,
    QUERY_STATUS,
    TEACH_FORGET,
    TEACH_SET,
    VIEW_IMAGE,
)
from sceneq_tools.security.authority import AUTHORITY, CERTIFICATE, KEY, Authority

from support.fake_bus import FakeBus
from support.furnished_node import RoutingHome

ASKED = (
    *(QUERY_ASK, QUERY_INSTANCES, QUERY_LABEL, QUERY_LABELS, QUERY_STATUS),
    *(TEACH_SET, TEACH_FORGET),
)
JPEG = b"\xff\xd8\xffpicture"


def connected(home: RoutingHome) -> FakeBus:
    """Return a bus on which the routing node answers."""
    bus = FakeBus()
    for topic in ASKED:
        bus.answer(topic, lambda request: home.bus.handler(request.key)(request))

    def picture(request: Any) -> Reply:
        if request.parameters["seq"] != "10":
            raise QueryError("not_found", "no image of this keyframe")
        return Reply(JPEG, "image/jpeg")

    bus.answer(VIEW_IMAGE, picture)
    return bus


class Web:
    """An open gateway and a client for it."""

    def __init__(self, **params: Any) -> None:
        self.home = RoutingHome()
        self.bus = connected(self.home)
        self.node = Gateway(Gateway.Params(port=0, **params), self.bus.context)
        self.node.open(self.bus)
        self.address = f"127.0.0.1:{self.bus.reported['port']}"
        self.client = httpx2.Client(base_url=f"http://{self.address}", timeout=20)

    def close(self) -> None:
        self.client.close()
        self.node.close()


@pytest.fixture
def words(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setitem(BACKENDS["encoder"], "words", "support.furnished:WordEncoder")


@pytest.fixture
def web(words: None) -> Iterator[Web]:
    web = Web()
    yield web
    web.close()


def problem(response: httpx2.Response) -> tuple[int, str]:
    assert response.headers["content-type"] == "application/problem+json"
    body = response.json()
    jsonschema.validate(body, document()["components"]["schemas"]["Problem"])
    assert body["status"] == response.status_code
    return response.status_code, body["detail"]


def test_a_question_is_answered_as_on_the_bus(web: Web) -> None:
    response = web.client.post("/ask", json={"question": "cup", "k": 2})
    answer = response.json()
    jsonschema.validate(answer, ANSWER)
    over_bus = web.home.ask("cup", k="2")
    assert [one["id"] for one in answer["instances"]] == [
        one["id"] for one in over_bus["instances"]
    ]
    fast = web.client.post("/ask", json={"question": "cup", "mode": "fast"}).json()
    assert fast["route"] == "fast"


def test_things_are_listed_named_and_shown(web: Web) -> None:
    listed = web.client.get("/instances", params={"k": 3, "after": 2}).json()["instances"]
    assert [one["id"] for one in listed] == [3, 4, 5]
    assert web.client.get("/instances/3").json()["instances"][0]["id"] == 3
    named = web.client.get("/instances/3/label", params={"labels": "cup,lamp"}).json()
    assert {one["label"] for one in named["labels"]} == {"cup", "lamp"}
    assert web.client.put("/instances/3/name", json={"name": "Ada's"}).status_code == 200
    assert web.client.get("/instances/3/label").json()["labels"][0]["label"] == "Ada's"
    assert web.client.delete("/instances/3/name").status_code == 200
    assert web.client.get("/instances/3/label").json()["labels"][0]["label"] != "Ada's"
    assert web.client.get("/views/10.jpg").content == JPEG
    assert web.client.get("/labels").json()["count"] == 10
    assert web.client.get("/scene").json()["scene"] == "room"


@pytest.mark.parametrize(
    ("method", "path", "body", "status", "detail"),
    [
        ("POST", "/ask", b"{", 400, "the body is not JSON"),
        ("POST", "/ask", b'{"question": " "}', 400, "body/question"),
        ("POST", "/ask", b'{"question": "cup", "k": 0}', 400, "body/k: 0 is less"),
        ("POST", "/ask", b'{"question": "cup", "x": 0}', 400, "'x' was unexpected"),
        ("GET", "/instances?k=many", b"", 400, "k: 'many'"),
        ("GET", "/instances?limit=3", b"", 400, "unknown parameter limit"),
        ("GET", "/instances?k=3&k=4", b"", 400, "k is said twice"),
        ("GET", "/instances/9999", b"", 404, "no such instance: 9999"),
        ("GET", "/instances/cup", b"", 404, "id: 'cup'"),
        ("GET", "/views/7.jpg", b"", 404, "no image"),
        ("GET", "/elsewhere", b"", 404, "Not Found"),
        ("GET", "/ask", b"", 405, "Method Not Allowed"),
        ("PUT", "/instances/3/name", b"[]", 400, "body: [] is not of type 'object'"),
        ("POST", "/ask", b" " * 70_000, 413, "the limit is 65536 bytes"),
    ],
)
def test_what_is_asked_wrongly_is_told_as_a_problem(
    web: Web, method: str, path: str, body: bytes, status: int, detail: str
) -> None:
    got = problem(web.client.request(method, path, content=body or None))
    assert got[0] == status
    assert detail in got[1]


def test_what_goes_wrong_behind_is_told_too(web: Web) -> None:
    def refuse(_: Any) -> Reply:
        raise QueryError("busy", "too many wait", "later", 1500)

    web.bus.answer(QUERY_ASK, refuse)
    busy = web.client.post("/ask", json={"question": "cup"})
    assert problem(busy) == (503, "too many wait")
    assert busy.headers["retry-after"] == "2"
    web.bus.answer(QUERY_ASK, lambda _: None)
    assert problem(web.client.post("/ask", json={"question": "cup"}))[0] == 503
    web.bus.answer(QUERY_ASK, lambda _: Reply(b"[]", ""))
    assert problem(web.client.post("/ask", json={"question": "cup"}))[0] == 502
    assert web.bus.counters == {"questions_refused": 1, "questions_unanswered": 1}


def test_a_body_without_a_length_is_limited_too(web: Web) -> None:
    chunks = (b" " * 10_000 for _ in range(10))
    assert problem(web.client.post("/ask", content=chunks))[0] == 413


def test_nobody_asks_through_a_visitors_browser(web: Web) -> None:
    foreign = web.client.get("/scene", headers={"Host": "rebound.example"})
    assert problem(foreign) == (421, "this is not rebound.example")
    other_page = web.client.post(
        "/ask", json={"question": "cup"}, headers={"Origin": "http://evil.example"}
    )
    assert problem(other_page)[0] == 403
    own = web.client.get("/scene", headers={"Origin": f"http://{web.address}"})
    assert own.status_code == 200
    assert "access-control-allow-origin" not in own.headers
    assert "default-src 'self'" in own.headers["content-security-policy"]
    with pytest.raises(InvalidStatus), connect(f"ws://{web.address}/events", origin="http://evil"):
        pass


def test_other_machines_need_a_token(words: None, monkeypatch: pytest.MonkeyPatch) -> None:
    open_to_all = Gateway(Gateway.Params(host="0.0.0.0", port=0), FakeBus().context)
    with pytest.raises(ValueError, match=TOKEN_VARIABLE):
        open_to_all.open(FakeBus())
    monkeypatch.setenv(TOKEN_VARIABLE, "secret")
    web = Web()
    try:
        assert problem(web.client.get("/scene"))[0] == 401
        wrong = web.client.get("/scene", headers={"Authorization": "Bearer secre"})
        assert problem(wrong)[0] == 401
        right = web.client.get("/scene", headers={"Authorization": "Bearer secret"})
        assert right.status_code == 200
        assert web.client.get("/").status_code == 200  # the page itself, which asks for the token
        with pytest.raises(InvalidStatus), connect(f"ws://{web.address}/events"):
            pass
        with connect(f"ws://{web.address}/events", subprotocols=["sceneq.token.secret"]) as page:
            web.client.post(
                "/ask", json={"question": "cup"}, headers={"Authorization": "Bearer secret"}
            )
            assert json.loads(page.recv(10))["type"] == "answer"
    finally:
        web.close()


def test_with_tls_a_client_shows_a_certificate(words: None, tmp_path: Path) -> None:
    authority = Authority.create(tmp_path / "ca", datetime.now(UTC))
    for who in ("gateway", "client"):
        hosts = ["127.0.0.1"]
        authority.issue(tmp_path / who, who, "test", hosts, datetime.now(UTC), 1)
    files = {name: str(tmp_path / "gateway" / name) for name in (CERTIFICATE, KEY, AUTHORITY)}
    web = Web(tls=TlsParams(files[CERTIFICATE], files[KEY], files[AUTHORITY]))
    trust = ssl.create_default_context(cafile=files[AUTHORITY])
    address = f"https://{web.address}/scene"
    try:
        with httpx2.Client(verify=trust) as stranger, pytest.raises(httpx2.TransportError):
            stranger.get(address)
        trust.load_cert_chain(tmp_path / "client" / CERTIFICATE, tmp_path / "client" / KEY)
        with httpx2.Client(verify=trust) as known:
            assert known.get(address).status_code == 200
    finally:
        web.close()


def test_where_the_port_is_taken_the_next_is(words: None) -> None:
    first, second = Web(), None
    try:
        taken = int(first.bus.reported["port"])
        bus = FakeBus()
        second = Gateway(Gateway.Params(port=taken), bus.context)
        second.open(bus)
        assert taken < int(bus.reported["port"]) <= taken + 19
    finally:
        first.close()
        if second is not None:
            second.close()


def test_an_address_of_another_machine_is_refused(words: None) -> None:
    node = Gateway(
        Gateway.Params(host="192.0.2.1", tls=TlsParams("a", "b", "c")), FakeBus().context
    )
    with pytest.raises(ValueError, match=r"tls: .*No such file"):
        node.open(FakeBus())
    server = WebServer(None, "192.0.2.1", 8480, 1, None)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"192\.0\.2\.1:8480: Cannot assign"):
        server.open()


def test_pages_hear_what_happens(web: Web) -> None:
    with connect(f"ws://{web.address}/events") as page:
        web.client.post("/ask", json={"question": "cup"})
        answer = json.loads(page.recv(10))
        assert answer["answer"]["question"] == "cup"
        beat = Health("views", Counters()).message("views", {})
        web.node.step(Received(HEALTH, "sceneq/health/views", {"node": "views"}, beat))
        heard = json.loads(page.recv(10))
        assert (heard["type"], heard["node"]) == ("health", "views")
    with pytest.raises(ConnectionClosed):
        page.recv(1)


def test_the_cloud_comes_only_when_it_is_another(web: Web) -> None:
    from support.furnished_node import map_delta_of

    one = np.array([7], np.int32)
    delta = map_delta_of(
        (), 3, 1, voxel_id=np.zeros(1, np.int32), voxel_coord=np.ones((1, 3), np.int32),
        points_world=np.full((1, 3), 0.5, np.float32), rgb=np.full((1, 3), 9, np.uint8),
        superpoint_id=one,
    )  # fmt: skip
    web.bus.deliver(web.node, MAP_DELTA, delta)
    response = web.client.get("/cloud")
    data = response.content
    assert data[:4] == b"SQC1"
    assert int.from_bytes(data[4:8], "little") == 1
    np.testing.assert_array_equal(np.frombuffer(data[20:32], "<f4"), [0.5] * 3)
    assert data[32:36] == b"\t\t\t\0"
    assert len(data) == 40
    tag = response.headers["etag"]
    assert tag == '"3:1"'
    assert web.client.get("/cloud", headers={"If-None-Match": tag}).status_code == 304


def test_a_slow_page_loses_the_oldest_and_is_told() -> None:
    import asyncio

    async def heard() -> list[Any]:
        hub = Hub(1)
        listener = hub.join()
        assert listener is not None
        assert hub.join() is None
        for number in range(MAX_WAITING + 2):
            hub.tell({"n": number})
        events = await listener.take()
        hub.leave(listener)
        assert hub.count == 0
        return events

    events = asyncio.run(heard())
    assert events[0] == {"type": "lost", "count": 2}
    assert [event["n"] for event in events[1:]] == list(range(2, MAX_WAITING + 2))


def test_every_page_is_as_its_description_says(words: None) -> None:
    desk = Desk(connected(RoutingHome()), "room", 5.0)
    access = Access("", LOOPBACK | {"testserver"}, 65536)
    app = application(Pages(desk, Hub(4), lambda: ("1:1", b"SQC1")), access)
    described = schemathesis.openapi.from_asgi("/openapi.json", app)
    tried = 0
    for operation in described.get_all_operations():

        @given(case=operation.ok().as_strategy())
        @settings(max_examples=20, deadline=None, derandomize=True, database=None)
        def conforms(case: Any) -> None:
            # A question without a word, such as a comma, is refused behind the gateway.
            case.call_and_validate(excluded_checks=[positive_data_acceptance])

        conforms()
        tried += 1
    assert tried == 10
