"""Units: one for the router, one for each node, and a target that starts and stops them all."""

from sceneq_nodes._credentials import ACCESS, AUTHORITY, CERTIFICATE, KEY
from sceneq_tools.deploy.site import CONFIG, GRAPH_FILE, NODE_ROLE, ROUTER_ROLE, Site
from sceneq_tools.graph import ROUTER, GraphNode
from sceneq_tools.supervisor_config import START_S, STOP_S

PYTHON = "/opt/sceneq/bin/python"
TARGET = "sceneq.target"
RESTART = {"on-failure": "on-failure", "always": "always", "never": "no"}
FILES = {
    ROUTER_ROLE: (AUTHORITY, CERTIFICATE, KEY, ACCESS),
    NODE_ROLE: (AUTHORITY, CERTIFICATE, KEY),
}

_UNIT = """\
# Made by `sceneq render --target systemd`; change graph.yaml instead.
[Unit]
Description=Scene-Q {name} of scene {scene} on {machine}
{order}PartOf={target}
StartLimitIntervalSec={interval_s}
StartLimitBurst={burst}

[Service]
Type=exec
User=sceneq
Group=sceneq
ExecStart={python} -P -m sceneq_nodes{argument}
{environment}
{credentials}Restart={restart}
RestartSec=100ms
RestartPreventExitStatus=2
TimeoutStopSec={stop_s}
KillMode=mixed
StateDirectory=sceneq
StateDirectoryMode=0700
UMask=0077
NoNewPrivileges=yes
ProtectSystem=strict
ProtectHome=read-only
PrivateTmp=yes
ProtectKernelTunables=yes
ProtectControlGroups=yes
RestrictSUIDSGID=yes
LimitMEMLOCK=infinity

[Install]
WantedBy={target}
"""
_TARGET = """\
# Made by `sceneq render --target systemd`; change graph.yaml instead.
[Unit]
Description=Scene-Q on {machine}: scene {scene}
Wants={units}
After=network-online.target
Wants=network-online.target

[Install]
WantedBy=multi-user.target
"""
_README = """\
Scene {scene} on {machine}, made from graph.yaml. As root, on that machine:

  useradd --system --home-dir /var/lib/sceneq sceneq
  python3 -m venv /opt/sceneq && /opt/sceneq/bin/pip install sceneq
  install -D -m 0644 {graph} router.json5 node.json5 -t {config}
  install -m 0644 *.service *.target -t /etc/systemd/system
{secrets}  systemctl daemon-reload && systemctl enable --now {target}

Look: systemctl list-dependencies {target}; journalctl -u 'sceneq-*' -f; sceneq status
"""
_SECRETS = """\
  install -d -m 0700 {config}/credentials/router {config}/credentials/node
  install -m 0600 SITE/router/* -t {config}/credentials/router   # of `sceneq secure init SITE`
  install -m 0600 SITE/{role}/* -t {config}/credentials/node
"""


def files(site: Site) -> dict[str, str]:
    """Return file name -> content for one machine."""
    names = [_unit_name(name) for name in (ROUTER, *(node.id for node in site.plan.nodes))]
    words = {"machine": site.machine, "scene": site.plan.scene}
    units = {_unit_name(node.id): _node_unit(site, node) for node in site.plan.nodes}
    return {
        GRAPH_FILE: site.graph_json(),
        **site.zenoh_files(),
        _unit_name(ROUTER): _router_unit(site),
        **units,
        TARGET: _TARGET.format(units=" ".join(names), **words),
        "README": _readme(site),
    }


def _router_unit(site: Site) -> str:
    order = "After=network-online.target\nWants=network-online.target\n"
    return _unit(site, ROUTER, " router", order, "always", 0, ROUTER_ROLE)


def _node_unit(site: Site, node: GraphNode) -> str:
    router = _unit_name(ROUTER)
    order = f"After={router}\nWants={router}\n"
    restart, burst = RESTART[node.restart_policy], node.max_restarts + 1
    keys = "".join(f"EnvironmentFile=-{CONFIG}/{key}.env\n" for key in site.keys(node))
    return _unit(site, node.id, "", order, restart, burst, NODE_ROLE, keys)


def _unit(
    site: Site,
    name: str,
    argument: str,
    order: str,
    restart: str,
    burst: int,
    role: str,
    keys: str = "",
) -> str:
    """``burst`` failed starts within their time give a unit up, 0 = it is never given up."""
    environment = site.environment(name)
    if site.encrypted:
        environment["SCENEQ_CREDENTIALS"] = "%d"
    return _UNIT.format(
        name=name,
        machine=site.machine,
        scene=site.plan.scene,
        order=order,
        target=TARGET,
        python=PYTHON,
        argument=argument,
        environment="\n".join(f"Environment={key}={value}" for key, value in environment.items()),
        credentials=keys + (_credentials(role) if site.encrypted else ""),
        restart=restart,
        stop_s=STOP_S,
        interval_s=burst * START_S,
        burst=burst,
    )


def _credentials(role: str) -> str:
    """systemd reads the files as root and shows them, read-only, to this unit alone."""
    folder = CONFIG / "credentials" / role
    return "".join(f"LoadCredential={file}:{folder / file}\n" for file in FILES[role])


def _readme(site: Site) -> str:
    role = "robot" if any(node.node_kind == "ingest" for node in site.plan.nodes) else "server"
    secrets = _SECRETS.format(config=CONFIG, role=role) if site.encrypted else ""
    words = {"machine": site.machine, "scene": site.plan.scene, "graph": GRAPH_FILE}
    return _README.format(config=CONFIG, target=TARGET, secrets=secrets, **words)


def _unit_name(name: str) -> str:
    return f"sceneq-{name}.service"
