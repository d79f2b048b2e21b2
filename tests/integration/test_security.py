"""Who may do what, on a real router with real certificates."""

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import pytest
import zenoh

from sceneq_nodes._bus import ForeignSample
from sceneq_nodes._client import Client
from sceneq_nodes._credentials import Credentials
from sceneq_nodes._foreign import ForeignSession
from sceneq_nodes._runtime import close, open_session
from sceneq_schemas.topics import CONTROL, FRAME, MAP_DELTA, QUERY_STATUS
from sceneq_tools.security.authority import Authority

from support.live_graph import free_port, run

pytestmark = pytest.mark.integration

PATIENCE_S = 60.0
QUIET_S = 1.0
"""How long nothing arrives where nothing may; what may arrives within milliseconds."""
GRAPH = """\
nodes:
  - id: ingest
    params: {source: {kind: ros2, colour_topic: /cam/image_raw, depth_topic: /cam/depth, domain: 7}}
  - {id: ros, params: {domain: 7}}
"""
COLOUR, STATIC = "7/cam/image_raw/sensor_msgs::msg::dds_::Image_/RIHS01_1", "7/tf_static/tf/hash"
SPEED, DETECTIONS = "7/cmd_vel/geometry_msgs::msg::dds_::Twist_/hash", "7/scene_q/detections/d/h"
OTHER = "7/scene_q/other/type/hash"
COMMAND = CONTROL.key(node="ingest", verb="list")


class Site:
    """A router that enforces its rules, credentials, and a node that serves and hears."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.endpoint = f"tls/127.0.0.1:{free_port()}"
        self.heard: list[str] = []
        (folder / "graph.yaml").write_text(GRAPH)
        scenes = ("--scene", "kitchen", "--scene", "office")
        self._sceneq("secure", "init", "site", *scenes, "--graph", "graph.yaml")
        issued = (("client", "kitchen"), ("client", ""), ("viewer", "kitchen"), ("ros", ""))
        for role, scene in issued:
            chosen = ("--scene", scene) if scene else ()
            out = f"{role}{scene and '.'}{scene}"
            self._sceneq("secure", "issue", "site", role, *chosen, "--out", f"site/{out}")

    def _sceneq(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "sceneq_tools", *arguments]
        subprocess.run(command, cwd=self.folder, check=True, stdout=subprocess.DEVNULL)

    def credentials(self, who: str) -> Credentials:
        return Credentials(self.folder / "site" / who)

    def client(self, who: str) -> Client:
        return Client(self.endpoint, PATIENCE_S, self.credentials(who))

    def node(self) -> zenoh.Session:
        """Join as a node that serves two scenes and a command, and hears frames."""
        session = open_session(self.endpoint, PATIENCE_S, self.credentials("server"))
        session.declare_subscriber(FRAME.selector(), lambda s: self.heard.append(str(s.key_expr)))
        for key in (COMMAND, *(QUERY_STATUS.key(scene=s) for s in ("kitchen", "office"))):
            session.declare_queryable(key, lambda q, key=key: q.reply(key, b'{"said": true}'))
        return session


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    site = Site(tmp_path_factory.mktemp("secure"))
    environment = os.environ | {"SCENEQ_CREDENTIALS": str(site.folder / "site" / "router")}
    command = [sys.executable, "-m", "sceneq_nodes", "router", "--endpoint", site.endpoint]
    router = subprocess.Popen(command, env=environment)
    node = None
    try:
        node = until_served(site)
        yield site
    finally:
        if node is not None:
            close(node)
        router.terminate()
        assert router.wait(PATIENCE_S) == 0


def until_served(site: Site) -> zenoh.Session:
    """Return the node once all it declares has reached the router: what is asked came last."""
    session = site.node()
    with site.client("client") as client:
        deadline = time.monotonic() + PATIENCE_S
        while not answers(client, QUERY_STATUS.key(scene="office")):
            assert time.monotonic() < deadline
            time.sleep(0.1)
    return session


def answers(client: Client, key: str) -> bool:
    replies, _ = client.get(key, timeout_s=3.0)
    return bool(replies)


def test_a_client_asks_and_one_of_a_scene_asks_that_scene_only(site: Site) -> None:
    with site.client("client") as anyone, site.client("client.kitchen") as cook:
        for scene in ("kitchen", "office"):
            assert answers(anyone, QUERY_STATUS.key(scene=scene))
        assert answers(cook, QUERY_STATUS.key(scene="kitchen"))
        assert not answers(cook, QUERY_STATUS.key(scene="office"))
        assert not answers(cook, QUERY_STATUS.selector())  # all scenes at once


def test_only_an_operator_commands_nodes(site: Site) -> None:
    for who, reached in (("operator", True), ("client", False), ("viewer.kitchen", False)):
        with site.client(who) as client:
            assert answers(client, COMMAND) is reached, who


def test_a_client_cannot_write_frames(site: Site) -> None:
    for who in ("client", "viewer.kitchen", "operator"):
        with site.client(who) as client:
            client.publish(FRAME.key(robot="r1", sensor=who.replace(".", "_")), b"x", "text/plain")
            time.sleep(QUIET_S / 2)
    with site.client("robot") as robot:
        robot.publish(FRAME.key(robot="r1", sensor="camera"), b"x", "text/plain")
        deadline = time.monotonic() + PATIENCE_S
        while not site.heard and time.monotonic() < deadline:
            time.sleep(0.05)
    assert site.heard == [FRAME.key(robot="r1", sensor="camera")]


def test_a_viewer_of_a_scene_sees_that_map_only(site: Site) -> None:
    seen: dict[str, list[str]] = {"viewer.kitchen": [], "client": []}
    with site.client("viewer.kitchen") as viewer, site.client("client") as client:
        for name, session in (("viewer.kitchen", viewer), ("client", client)):
            for scene in ("kitchen", "office"):
                heard = seen[name]
                key = MAP_DELTA.key(scene=scene)
                session.subscribe(key, lambda key, *_, heard=heard: heard.append(key))
        with site.client("robot") as robot:
            deadline = time.monotonic() + PATIENCE_S
            while not seen["viewer.kitchen"] and time.monotonic() < deadline:
                for scene in ("office", "kitchen"):
                    robot.publish(MAP_DELTA.key(scene=scene), b"x", MAP_DELTA.encoding)
                time.sleep(QUIET_S)  # until the router knows who wants what
    assert set(seen["viewer.kitchen"]) == {MAP_DELTA.key(scene="kitchen")}
    assert seen["client"] == []


def test_of_ros_the_topics_of_the_graph_pass_and_no_others(site: Site) -> None:
    wanted = {(COLOUR, b"x"), (STATIC, b"latched")}
    heard: set[tuple[str, bytes]] = set()
    told: set[str] = set()
    robot, stranger, node = (
        open_session(site.endpoint, PATIENCE_S, site.credentials(who))
        for who in ("ros", "client", "robot")
    )
    try:
        still = zenoh.ext.declare_advanced_publisher(
            robot, STATIC, cache=zenoh.ext.CacheConfig(max_samples=1), publisher_detection=True
        )
        still.put(b"latched")
        ours = ForeignSession(node)

        def take(sample: ForeignSample) -> None:
            heard.add((sample.key, sample.payload))

        for key in (COLOUR, SPEED):
            ours.listen(key, take)
        ours.listen("7/tf_static/*/*", take, latched=True)
        for key in (DETECTIONS, OTHER):
            robot.declare_subscriber(key, lambda sample: told.add(str(sample.key_expr)))
        deadline = time.monotonic() + PATIENCE_S
        while not (wanted <= heard and told) and time.monotonic() < deadline:
            # What is denied goes first on each link: it would have come when the others have.
            stranger.put(COLOUR, b"forged")
            for key in (SPEED, FRAME.key(robot="ros", sensor="forged"), COLOUR):
                robot.put(key, b"x")
            for key in (OTHER, DETECTIONS):
                ours.publish(key, b"x", b"")
            time.sleep(0.1)
        assert heard == wanted
        assert told == {DETECTIONS}
        assert FRAME.key(robot="ros", sensor="forged") not in site.heard
    finally:
        for session in (robot, stranger, node):
            close(session)


def test_nobody_without_a_certificate_of_this_site_joins(site: Site, tmp_path: Path) -> None:
    other = Authority.create(tmp_path / "authority", datetime.now(UTC))
    other.issue(tmp_path / "robot", "robot", "impostor", (), datetime.now(UTC), 1)
    with pytest.raises(ConnectionError, match="no router at tls/"):
        Client(site.endpoint, 2.0, Credentials(tmp_path / "robot"))
    with pytest.raises(ConnectionError, match="no router at tls/"):
        Client(site.endpoint, 2.0)
    with pytest.raises(ConnectionError, match="no router at tcp/"):
        Client(site.endpoint.replace("tls/", "tcp/"), 2.0)


def test_a_router_whose_rules_are_missing_does_not_start(site: Site, tmp_path: Path) -> None:
    environment = os.environ | {"SCENEQ_CREDENTIALS": str(site.folder / "site" / "robot")}
    command = [sys.executable, "-m", "sceneq_nodes", "router", "--endpoint", "tls/127.0.0.1:0"]
    done = subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=PATIENCE_S
    )
    assert done.returncode == 2
    assert "access.json" in done.stderr


def test_the_command_line_shows_what_the_environment_names(site: Site) -> None:
    shown = os.environ | {"SCENEQ_CREDENTIALS": str(site.folder / "site" / "operator")}
    command = [sys.executable, "-m", "sceneq_tools", "status", "--connect", site.endpoint]
    done = subprocess.run(command, env=shown, capture_output=True, text=True, timeout=PATIENCE_S)
    assert "no router" not in done.stderr
    stranger = run(*command)
    assert stranger.returncode == 1
    assert stranger.stderr.startswith(f"sceneq: no router at {site.endpoint}")
