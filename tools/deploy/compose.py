"""A compose file: one container for the router, one for each node, on the router's network."""

from typing import Any

import yaml

from sceneq_tools.deploy.site import CONFIG, GRAPH_FILE, NODE_ROLE, ROUTER_ROLE, STORE, Site
from sceneq_tools.graph import ROUTER, GraphNode

WORDS = "# Made by `sceneq render --target compose`; change graph.yaml instead.\n"
RESTART = {"on-failure": "on-failure", "always": "unless-stopped", "never": "no"}
VARIABLE = "SCENEQ_CREDENTIALS_DIR"
SHM = "512m"


def files(site: Site, image: str) -> dict[str, str]:
    """Return file name -> content for one machine."""
    text = yaml.safe_dump(compose(site, image), sort_keys=False, width=100)
    return {GRAPH_FILE: site.graph_json(), **site.zenoh_files(), "compose.yaml": WORDS + text}


def compose(site: Site, image: str) -> dict[str, Any]:
    """Return the document.

    All containers share the router's network, so that nodes find it where they would without
    containers, and its shared memory, so that pictures need not go through the network.
    """
    services = {ROUTER: _router(site, image)}
    services |= {node.id: _node(site, node, image) for node in site.plan.nodes}
    return {
        "name": f"sceneq-{site.machine}",
        "services": services,
        **({"volumes": {"store": {}}} if site.plan.store else {}),
    }


def _router(site: Site, image: str) -> dict[str, Any]:
    ports = [f"{port}:{port}" for port in site.ports()]
    return {
        **_service(site, ROUTER, image, ROUTER_ROLE, []),
        "command": ["python", "-P", "-m", "sceneq_nodes", ROUTER],
        "restart": "unless-stopped",
        "ipc": "shareable",
        "shm_size": SHM,
        **({"ports": ports} if ports else {}),
    }


def _node(site: Site, node: GraphNode, image: str) -> dict[str, Any]:
    mounts = [f"{folder}:{folder}:ro" for folder in site.folders(node)]
    if site.plan.store:
        mounts.append(f"store:{STORE}")
    service = _service(site, node.id, image, NODE_ROLE, mounts)
    service["environment"] |= {key: f"${{{key}:-}}" for key in site.keys(node)}
    restart = RESTART[node.restart_policy]
    if restart == "on-failure":
        restart = f"on-failure:{max(node.max_restarts, 1)}"
    return {
        **service,
        "command": ["python", "-P", "-m", "sceneq_nodes"],
        "restart": restart,
        "network_mode": f"service:{ROUTER}",
        "ipc": f"service:{ROUTER}",
        "depends_on": [ROUTER],
    }


def _service(site: Site, name: str, image: str, role: str, mounts: list[str]) -> dict[str, Any]:
    volumes = [f"./{GRAPH_FILE}:{CONFIG / GRAPH_FILE}:ro", *mounts]
    environment = site.environment(name)
    if site.encrypted:
        folder = str(CONFIG / "credentials" / role)
        volumes.append(f"${{{VARIABLE}:?the folder with router/ and node/}}/{role}:{folder}:ro")
        environment["SCENEQ_CREDENTIALS"] = folder
    return {
        "image": image,
        "environment": environment,
        "volumes": volumes,
        "read_only": True,
        "tmpfs": ["/tmp"],
        "cap_drop": ["ALL"],
        "security_opt": ["no-new-privileges:true"],
        "stop_grace_period": "5s",
    }
