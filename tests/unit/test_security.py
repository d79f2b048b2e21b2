"""Certificates, roles and the rules that follow from them."""

import json
import stat
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from typer.testing import CliRunner

from sceneq_nodes._credentials import VARIABLE, Credentials, given_credentials
from sceneq_nodes._session import client_config
from sceneq_nodes.ros.passage import RosKeys
from sceneq_schemas.topics import CONTROL, FRAME, MAP_DELTA, MAP_SNAPSHOT, TEACH_SET
from sceneq_tools.cli import app
from sceneq_tools.errors import UserError
from sceneq_tools.graph import Override, Router, load
from sceneq_tools.graph_plan import encrypted, plan
from sceneq_tools.launcher import need_ros_passage, node_credentials
from sceneq_tools.security.access import access_rules
from sceneq_tools.security.authority import Authority
from sceneq_tools.security.roles import NO_ROS, ROLES, grants
from sceneq_tools.security.ros_keys import denied, keys_in_graph
from sceneq_tools.security.site import Site

NOW = datetime(2030, 1, 2, 3, tzinfo=UTC)


def certificate(folder: Path) -> x509.Certificate:
    return x509.load_pem_x509_certificate((folder / "cert.pem").read_bytes())


def issued(folder: Path, subject: str = "client", hosts: tuple[str, ...] = ()) -> Path:
    authority = Authority.create(folder / "authority", NOW)
    authority.issue(folder / "one", subject, "anna", hosts, NOW, 30)
    return folder / "one"


def may(role: str, message: str, flow: str, key: str, ros: RosKeys = NO_ROS) -> bool:
    """Tell whether a role's grants name exactly this key."""
    return any(
        message in grant.messages and flow in grant.flows and key in grant.keys
        for grant in grants(role, ros=ros)
    )


def run(*arguments: str) -> str:
    done = CliRunner().invoke(app, ["secure", *arguments])
    if done.exception is not None:
        raise done.exception
    return done.stdout


def test_a_certificate_says_whose_key_it_has_and_whose_key_signed_it(tmp_path: Path) -> None:
    folder = issued(tmp_path, "client.kitchen", ())
    made = certificate(folder)
    authority = x509.load_pem_x509_certificate((folder / "ca.pem").read_bytes())
    own, of_authority = (
        one.extensions.get_extension_for_class(x509.SubjectKeyIdentifier).value.digest
        for one in (made, authority)
    )
    assert own != of_authority
    for one in (made, authority):
        signed_by = one.extensions.get_extension_for_class(x509.AuthorityKeyIdentifier).value
        assert signed_by.key_identifier == of_authority


def test_a_certificate_names_its_subject_and_is_signed_by_the_authority(tmp_path: Path) -> None:
    folder = issued(tmp_path, "client.kitchen", ("robot.local", "192.168.1.20"))
    made = certificate(folder)
    (common,) = made.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    (unit,) = made.subject.get_attributes_for_oid(NameOID.ORGANIZATIONAL_UNIT_NAME)
    assert (common.value, unit.value) == ("client.kitchen", "anna")
    made.verify_directly_issued_by(x509.load_pem_x509_certificate((folder / "ca.pem").read_bytes()))
    names = made.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    assert names.get_values_for_type(x509.DNSName) == ["robot.local"]
    assert [str(one) for one in names.get_values_for_type(x509.IPAddress)] == ["192.168.1.20"]
    assert made.not_valid_before_utc <= NOW - timedelta(minutes=59)
    assert made.not_valid_after_utc == NOW + timedelta(days=30)
    public = made.public_key()
    assert isinstance(public, ec.EllipticCurvePublicKey)
    assert public.curve.name == "secp256r1"


def test_keys_are_for_their_owner_only(tmp_path: Path) -> None:
    folder = issued(tmp_path)
    for path in (folder / "key.pem", tmp_path / "authority" / "ca.key.pem"):
        assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    (folder / "key.pem").chmod(0o640)
    with pytest.raises(ValueError, match=r"key\.pem: others may read it"):
        Credentials(folder)


def test_nothing_that_exists_is_overwritten(tmp_path: Path) -> None:
    issued(tmp_path)
    key = (tmp_path / "authority" / "ca.key.pem").read_bytes()
    with pytest.raises(FileExistsError):
        Authority.create(tmp_path / "authority", NOW)
    with pytest.raises(FileExistsError):
        Authority.open(tmp_path / "authority").issue(tmp_path / "one", "x", "y", (), NOW, 1)
    assert (tmp_path / "authority" / "ca.key.pem").read_bytes() == key


def test_credentials_are_found_by_the_environment(tmp_path: Path) -> None:
    folder = issued(tmp_path)
    assert given_credentials({}) is None
    given = given_credentials({VARIABLE: str(folder)})
    assert given == Credentials(folder)
    link = client_config("tls/a:1", 1.0, given)["transport"]["link"]
    assert link["protocols"] == ["tls", "quic"]
    assert link["tls"]["enable_mtls"] is True
    assert link["tls"]["connect_private_key"] == str(folder / "key.pem")
    assert "tls" not in client_config("tcp/a:1", 1.0)["transport"]["link"]
    with pytest.raises(ValueError, match=r"nowhere/ca\.pem: no such file"):
        given_credentials({VARIABLE: "nowhere"})


def test_what_roles_may_do_follows_from_the_table_of_keys() -> None:
    asks, sees = "sceneq/query/**", MAP_DELTA.selector()
    for role in ("client", "viewer", "operator"):
        assert may(role, "query", "ingress", asks)
        assert not may(role, "put", "ingress", FRAME.selector())
    assert not may("client", "declare_subscriber", "ingress", sees)
    assert may("viewer", "declare_subscriber", "ingress", sees)
    assert may("viewer", "query", "ingress", MAP_SNAPSHOT.selector())
    for role in ("client", "viewer", "robot", "server"):
        assert not may(role, "query", "ingress", CONTROL.selector())
    assert may("operator", "query", "ingress", CONTROL.selector())
    assert may("operator", "query", "ingress", TEACH_SET.selector())
    assert not may("client", "query", "ingress", TEACH_SET.selector())
    assert may("robot", "put", "ingress", FRAME.selector())
    assert may("robot", "declare_queryable", "ingress", CONTROL.selector())


def test_a_role_of_one_scene_names_no_other() -> None:
    keys = [key for role in ("client", "viewer") for g in grants(role, "kitchen") for key in g.keys]
    assert "sceneq/query/kitchen/**" in keys
    assert [key for key in keys if "kitchen" not in key] == []
    with pytest.raises(ValueError, match="'robot' is not given for one scene"):
        grants("robot", "kitchen")
    with pytest.raises(ValueError, match="role 'king': expected one of router"):
        grants("king")


def test_the_rules_deny_by_default_and_every_policy_names_what_exists() -> None:
    access = access_rules(Site(("kitchen",)))
    assert (access["enabled"], access["default_permission"]) == (True, "deny")
    assert {rule["permission"] for rule in access["rules"]} == {"allow"}
    names = {subject["id"] for subject in access["subjects"]}
    assert names == {*ROLES, "client.kitchen", "viewer.kitchen"} - {"ros"}
    used = [rule for policy in access["policies"] for rule in policy["rules"]]
    assert sorted(used) == sorted(rule["id"] for rule in access["rules"])
    assert all(subject["cert_common_names"] == [subject["id"]] for subject in access["subjects"])


ROS_GRAPH = """\
scene: arm
nodes:
  - id: ingest
    params:
      source:
        kind: ros2
        colour_topic: /cam/color/image_raw
        depth_topic: /cam/depth/image_raw
        dialect: jazzy
        domain: 7
        pose: {kind: topic, topic: /odom}
  - {id: ros, params: {domain: 7}}
"""
COLOUR, DETECTIONS = "7/cam/color/image_raw/*/*", "7/scene_q/detections/*/*"
STATIC = "7/tf_static/*/*"


def ros_graph(folder: Path) -> Path:
    (folder / "graph.yaml").write_text(ROS_GRAPH)
    return folder / "graph.yaml"


def test_of_ros_those_topics_pass_that_the_graph_names(tmp_path: Path) -> None:
    ros = keys_in_graph(ros_graph(tmp_path))
    stems = ("cam/color/camera_info", "cam/color/image_raw", "cam/depth/camera_info",
             "cam/depth/image_raw", "odom", "tf", "tf_static")  # fmt: skip
    assert ros.read == tuple(f"7/{stem}/*/*" for stem in stems)
    assert ros.written == tuple(f"7/scene_q/{n}/*/*" for n in ("cloud", "detections", "markers"))
    assert (ros.latched, ros.tokens) == ((STATIC,), ("@ros2_lv/7/**",))
    assert may("ros", "put", "ingress", COLOUR, ros)
    assert may("robot", "put", "egress", COLOUR, ros)
    assert may("robot", "put", "ingress", DETECTIONS, ros)
    assert may("ros", "put", "egress", DETECTIONS, ros)
    assert may("ros", "declare_queryable", "ingress", f"{STATIC}/@adv/**", ros)
    assert may("ros", "reply", "ingress", STATIC, ros)
    assert not may("ros", "put", "ingress", DETECTIONS, ros)
    assert not may("robot", "put", "ingress", COLOUR, ros)
    keys = {key for grant in grants("ros", ros=ros) for key in grant.keys}
    assert not [key for key in keys if key.startswith("sceneq/")]
    for role in ("client", "viewer", "operator"):
        assert grants(role, ros=ros) == grants(role)


def test_keys_of_ros_are_denied_until_a_graph_is_told(tmp_path: Path) -> None:
    site, graph = str(tmp_path / "site"), ros_graph(tmp_path)
    run("init", site)
    with pytest.raises(UserError, match="ros: no topics are let through"):
        run("issue", site, "ros", "--out", str(tmp_path / "arm"))
    router = Credentials(tmp_path / "site" / "router")
    assert "7/tf/*/*" in denied(router.access(), keys_in_graph(graph))
    loaded, document = load(graph, [Override("", ("secure",), site, "--secure")])
    with pytest.raises(UserError, match=r"let no 7/cam/color/camera_info/\*/\* pass \(sceneq sec"):
        need_ros_passage(plan(loaded, document, "local"))
    assert "all scenes together, 10 keys of ROS" in run("init", site, "--graph", str(graph))
    assert denied(router.access(), keys_in_graph(graph)) == []
    need_ros_passage(plan(loaded, document, "local"))
    assert "arm: ros" in run("issue", site, "ros", "--out", str(tmp_path / "arm"))
    assert "10 keys of ROS" in run("init", site, "--scene", "kitchen")  # they stay
    graph.write_text("nodes: [{id: mapping}]")
    assert "ROS" not in run("init", site, "--graph", str(graph))


def test_with_credentials_every_link_is_encrypted() -> None:
    assert encrypted(Router()).listen == ["tls/127.0.0.1:7447"]
    with pytest.raises(UserError, match=r"tcp/0\.0\.0\.0:7447: not encrypted"):
        encrypted(Router(listen=["tcp/0.0.0.0:7447"]))
    with pytest.raises(UserError, match="tcp/server:7447: not encrypted"):
        encrypted(Router(connect=["tcp/server:7447"]))


def test_a_site_is_made_once_and_grows(tmp_path: Path) -> None:
    site = tmp_path / "site"
    assert "access rules for all scenes together" in run("init", str(site))
    before = (site / "robot" / "cert.pem").read_bytes()
    assert "kept, access rules for kitchen" in run("init", str(site), "--scene", "kitchen")
    assert (site / "robot" / "cert.pem").read_bytes() == before
    rules = json.loads((site / "router" / "access.json").read_text())
    assert "client.kitchen" in {one["id"] for one in rules["subjects"]}
    assert Credentials(site / "router").access() == rules
    assert node_credentials(site) == Credentials(site / "robot")


def test_credentials_are_issued_for_known_scenes_and_roles(tmp_path: Path) -> None:
    site, out = str(tmp_path / "site"), str(tmp_path / "anna")
    run("init", site, "--scene", "kitchen")
    said = run("issue", site, "client", "--scene", "kitchen", "--name", "anna", "--out", out)
    assert said.startswith(f"{out}: client.kitchen, for anna")
    with pytest.raises(UserError, match="there are credentials already"):
        run("issue", site, "client", "--out", out)
    with pytest.raises(UserError, match="--scene office: not known here"):
        run("issue", site, "client", "--scene", "office", "--out", str(tmp_path / "b"))
    with pytest.raises(UserError, match="no authority"):
        run("issue", str(tmp_path / "nowhere"), "client", "--out", str(tmp_path / "c"))
    with pytest.raises(UserError, match="must match"):
        run("init", site, "--scene", "a/**")


def test_up_says_what_is_missing(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"router/ca\.pem: no such file \(sceneq secure init"):
        node_credentials(tmp_path)
