"""A graph for two machines as units, manifests and compose files: complete, and without secrets."""

import json
import shutil
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from sceneq_nodes._launch import Launch, RouterLaunch, read_launch
from sceneq_tools import render_command
from sceneq_tools.deploy.site import Site, sites
from sceneq_tools.graph import load
from sceneq_tools.graph_check import check_nodes
from sceneq_tools.render_command import Target, rendered, write

GRAPH = """\
scene: kitchen
store: maps
{secure}
machines:
  edge:
    router:
      listen: [{protocol}/127.0.0.1:7447]
      connect:
        - {protocol}/sceneq-server:7448?prio=0-3
        - {protocol}/sceneq-server:7449?prio=4-7
  server:
    router:
      listen: [{protocol}/127.0.0.1:7447, {protocol}/0.0.0.0:7448, {protocol}/0.0.0.0:7449]
nodes:
  - id: ingest
    deploy: {{machine: edge}}
    params: {{source: {{kind: folder, path: /data/kitchen}}, rgb_codec: jpeg, depth_codec: delta}}
  - {{id: mapping, deploy: {{machine: edge}}, max_restarts: 9}}
  - {{id: routing, deploy: {{machine: edge}}}}
  - {{id: encoding, deploy: {{machine: server}}, restart_policy: always}}
  - id: reasoning
    deploy: {{machine: server}}
    params:
      reasoner: {{kind: openai, base_url: 'https://example.org/v1', model: m, key_env: VLM_KEY}}
"""
IMAGE = "sceneq:9"


def rendered_sites(folder: Path, secure: bool) -> dict[str, Site]:
    path = folder / "graph.yaml"
    words = {"secure": "secure: site" if secure else "", "protocol": "tls" if secure else "tcp"}
    path.write_text(GRAPH.format(**words))
    graph, document = load(path)
    check_nodes(graph, document)
    return {site.machine: site for site in sites(graph, document)}


@pytest.fixture
def plain(tmp_path: Path) -> dict[str, Site]:
    return rendered_sites(tmp_path, secure=False)


@pytest.fixture
def secured(tmp_path: Path) -> dict[str, Site]:
    return rendered_sites(tmp_path, secure=True)


@pytest.mark.parametrize("target", list(Target))
def test_no_file_names_a_secret_or_a_folder_of_this_machine(
    secured: dict[str, Site], target: Target, tmp_path: Path
) -> None:
    for site in secured.values():
        for name, text in rendered(target, site, IMAGE).items():
            assert "BEGIN" not in text, name
            assert str(tmp_path) not in text, name
            assert str(Path.cwd()) not in text, name


def test_the_processes_read_their_part_of_the_graph(
    secured: dict[str, Site], tmp_path: Path
) -> None:
    graph = tmp_path / "graph.json"
    graph.write_text(secured["edge"].graph_json())
    environment = {**secured["edge"].environment("mapping"), "SCENEQ_GRAPH": str(graph)}
    launch = read_launch([], environment)
    assert isinstance(launch, Launch)
    assert (launch.kind, launch.context.scene, launch.endpoint) == (
        *("mapping", "kitchen", "tls/127.0.0.1:7447"),
    )
    assert launch.context.store == Path("/var/lib/sceneq/kitchen")
    router = read_launch(["router"], {"SCENEQ_GRAPH": str(graph)})
    assert isinstance(router, RouterLaunch)
    assert list(router.connect) == [
        "tls/sceneq-server:7448?prio=0-3",
        "tls/sceneq-server:7449?prio=4-7",
    ]
    assert router.credentials is None


def test_units_of_a_robot(plain: dict[str, Site]) -> None:
    files = rendered(Target.SYSTEMD, plain["edge"], IMAGE)
    assert sorted(files) == [
        *("README", "graph.json", "node.json5", "router.json5", "sceneq-ingest.service"),
        *("sceneq-mapping.service", "sceneq-router.service", "sceneq-routing.service"),
        "sceneq.target",
    ]
    unit = files["sceneq-mapping.service"].splitlines()
    for line in (
        "ExecStart=/opt/sceneq/bin/python -P -m sceneq_nodes",
        "Environment=SCENEQ_NODE=mapping",
        "Environment=SCENEQ_GRAPH=/etc/sceneq/graph.json",
        "After=sceneq-router.service",
        "Restart=on-failure",
        "RestartPreventExitStatus=2",
        "StartLimitBurst=10",
        "StateDirectory=sceneq",
        "NoNewPrivileges=yes",
    ):
        assert line in unit
    assert "ExecStart=/opt/sceneq/bin/python -P -m sceneq_nodes router" in (
        files["sceneq-router.service"].splitlines()
    )
    assert "LoadCredential" not in files["sceneq-mapping.service"]
    wanted = next(line for line in files["sceneq.target"].splitlines() if "Wants=sceneq" in line)
    assert wanted.count(".service") == 4


def test_units_get_credentials_from_systemd(secured: dict[str, Site]) -> None:
    files = rendered(Target.SYSTEMD, secured["server"], IMAGE)
    router, encoding = files["sceneq-router.service"], files["sceneq-encoding.service"]
    assert "LoadCredential=access.json:/etc/sceneq/credentials/router/access.json" in router
    assert "LoadCredential=key.pem:/etc/sceneq/credentials/node/key.pem" in encoding
    assert "access.json" not in encoding
    assert "Environment=SCENEQ_CREDENTIALS=%d" in encoding
    assert "Restart=always" in encoding
    assert "EnvironmentFile=-/etc/sceneq/VLM_KEY.env" in files["sceneq-reasoning.service"]
    assert "SITE/server/*" in files["README"]


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="no systemd-analyze here")
@pytest.mark.parametrize("machine", ["edge", "server"])
def test_systemd_finds_nothing_wrong(
    secured: dict[str, Site], machine: str, tmp_path: Path
) -> None:
    units = tmp_path / "units"
    for name, text in rendered(Target.SYSTEMD, secured[machine], IMAGE).items():
        if name.startswith("sceneq"):  # it looks whether there is such a program
            write(units / name, text.replace("/opt/sceneq/bin/python", sys.executable))
    command = ["systemd-analyze", "verify", "--man=no", *map(str, sorted(units.iterdir()))]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "sceneq" not in done.stderr
    assert done.returncode == 0, done.stderr


def documents(site: Site) -> dict[str, dict[str, Any]]:
    text = rendered(Target.KUBERNETES, site, IMAGE)["manifests.yaml"]
    return {one["kind"]: one for one in yaml.safe_load_all(text)}


def test_manifests_of_a_server(secured: dict[str, Site]) -> None:
    found = documents(secured["server"])
    assert set(found) == {"ConfigMap", "PersistentVolumeClaim", "Deployment", "Service"}
    assert json.loads(found["ConfigMap"]["data"]["graph.json"])["scene"] == "kitchen"
    assert [port["port"] for port in found["Service"]["spec"]["ports"]] == [7448, 7449]
    deployment = found["Deployment"]["spec"]
    assert deployment["strategy"] == {"type": "Recreate"}
    labels = deployment["template"]["metadata"]["labels"]
    assert labels == deployment["selector"]["matchLabels"] == found["Service"]["spec"]["selector"]
    pod = deployment["template"]["spec"]
    assert [one["name"] for one in pod["containers"]] == ["router", "encoding", "reasoning"]
    volumes = {volume["name"]: volume for volume in pod["volumes"]}
    for container in pod["containers"]:
        assert {mount["name"] for mount in container["volumeMounts"]} <= set(volumes)
        assert container["securityContext"]["readOnlyRootFilesystem"] is True
        assert container["image"] == IMAGE
    assert volumes["node-credentials"]["secret"] == {
        "secretName": "sceneq-server-node",
        "defaultMode": stat.S_IRUSR,
    }
    (key,) = [one for one in pod["containers"][2]["env"] if one["name"] == "VLM_KEY"]
    assert key["valueFrom"]["secretKeyRef"]["name"] == "sceneq-keys"


def test_manifests_of_a_robot_show_its_recording_and_no_ports(plain: dict[str, Site]) -> None:
    found = documents(plain["edge"])
    assert "Service" not in found
    pod = found["Deployment"]["spec"]["template"]["spec"]
    (data,) = [volume for volume in pod["volumes"] if "hostPath" in volume]
    assert data["hostPath"]["path"] == "/data/kitchen"
    ingest = next(one for one in pod["containers"] if one["name"] == "ingest")
    (mount,) = [one for one in ingest["volumeMounts"] if one["name"] == data["name"]]
    assert mount == {"name": data["name"], "mountPath": "/data/kitchen", "readOnly": True}
    assert not [volume for volume in pod["volumes"] if "secret" in volume]


def test_compose_files(secured: dict[str, Site]) -> None:
    text = rendered(Target.COMPOSE, secured["server"], IMAGE)["compose.yaml"]
    compose = yaml.safe_load(text)
    assert list(compose["services"]) == ["router", "encoding", "reasoning"]
    router, encoding = compose["services"]["router"], compose["services"]["encoding"]
    assert router["ports"] == ["7448:7448", "7449:7449"]
    assert encoding["network_mode"] == encoding["ipc"] == "service:router"
    assert "ports" not in encoding
    assert encoding["restart"] == "unless-stopped"
    assert compose["services"]["reasoning"]["restart"] == "on-failure:5"
    assert compose["services"]["reasoning"]["environment"]["VLM_KEY"] == "${VLM_KEY:-}"
    assert compose["volumes"] == {"store": {}}
    for service in compose["services"].values():
        assert service["read_only"] is True
        assert any(
            "credentials" in volume and volume.endswith(":ro") for volume in service["volumes"]
        )


@pytest.mark.parametrize("target", list(Target))
def test_zenohd_could_read_the_router(secured: dict[str, Site], target: Target) -> None:
    import zenoh

    for name, text in rendered(target, secured["edge"], IMAGE).items():
        if name.endswith(".json5"):
            config = zenoh.Config.from_json5(text)
            assert json.loads(config.get_json("transport/link/tls/enable_mtls")) is True
            assert json.loads(config.get_json("mode")) == name.replace(
                "node.json5", "client"
            ).replace(".json5", "")


def test_the_command_writes_a_folder_for_each_machine(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rendered_sites(tmp_path, secure=False)
    out = tmp_path / "out"
    render_command.run(Target.COMPOSE, out, tmp_path / "graph.yaml", None, None)
    assert sorted(path.name for path in out.iterdir()) == ["edge", "server"]
    assert (out / "edge" / "compose.yaml").is_file()
    assert "edge: compose for 4 processes" in capsys.readouterr().out
