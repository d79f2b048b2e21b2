"""Manifests: a machine of the graph becomes one pod, its processes containers of it."""

from typing import Any

import yaml

from sceneq_tools.deploy.site import CONFIG, GRAPH_FILE, NODE_ROLE, ROUTER_ROLE, STORE, Site
from sceneq_tools.graph import ROUTER, GraphNode

WORDS = "# Made by `sceneq render --target kubernetes`; change graph.yaml instead.\n"
USER = 10001
SHM = "512Mi"
STORE_SIZE = "10Gi"
OWNER_READS = 0o400
MACHINE_LABEL = "sceneq.machine"


class _Readable(yaml.SafeDumper):
    """Writes texts of several lines as such."""


def _text(dumper: yaml.SafeDumper, text: str) -> yaml.ScalarNode:
    style = "|" if "\n" in text else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", text, style=style)


_Readable.add_representer(str, _text)


def files(site: Site, image: str) -> dict[str, str]:
    """Return file name -> content for one machine."""
    text = yaml.dump_all(manifests(site, image), Dumper=_Readable, sort_keys=False, width=100)
    return {**site.zenoh_files(), "manifests.yaml": WORDS + text}


def manifests(site: Site, image: str) -> list[dict[str, Any]]:
    """Return the documents: configuration, store, pod and, where others connect, a service.

    One pod, as the containers of a pod share the loopback interface, on which nodes find their
    router, and can share the memory through which pictures go. The kubelet brings back a container
    that ends, alone.
    """
    name = _name(site)
    config = {"apiVersion": "v1", "kind": "ConfigMap", "metadata": _metadata(site)}
    found = [{**config, "data": {GRAPH_FILE: site.graph_json()}}]
    if site.plan.store:
        claim = {"accessModes": ["ReadWriteOnce"], "resources": _requests(storage=STORE_SIZE)}
        found.append(
            {
                **_head("v1", "PersistentVolumeClaim", site, f"{name}-store"),
                "spec": claim,
            }
        )
    found.append(_deployment(site, image))
    if ports := site.ports():
        spec = {
            "selector": _labels(site),
            "ports": [_port(port, targetPort=port) for port in ports],
        }
        found.append({**_head("v1", "Service", site), "spec": spec})
    return found


def _deployment(site: Site, image: str) -> dict[str, Any]:
    containers = [_router(site, image), *(_node(site, node, image) for node in site.plan.nodes)]
    pod = {
        "nodeSelector": {MACHINE_LABEL: site.machine},
        "automountServiceAccountToken": False,
        "terminationGracePeriodSeconds": 5,
        "securityContext": {
            "runAsNonRoot": True,
            "runAsUser": USER,
            "runAsGroup": USER,
            "fsGroup": USER,
            "seccompProfile": {"type": "RuntimeDefault"},
        },
        "containers": containers,
        "volumes": _volumes(site),
    }
    spec = {
        "replicas": 1,
        "strategy": {"type": "Recreate"},  # two writers of one scene would disagree
        "selector": {"matchLabels": _labels(site)},
        "template": {"metadata": {"labels": _labels(site)}, "spec": pod},
    }
    return {**_head("apps/v1", "Deployment", site), "spec": spec}


def _router(site: Site, image: str) -> dict[str, Any]:
    container = _container(site, ROUTER, image, ROUTER_ROLE, [])
    if ports := site.ports():
        container["ports"] = [{"containerPort": port} for port in ports]
    return {**container, "command": ["python", "-P", "-m", "sceneq_nodes", ROUTER]}


def _node(site: Site, node: GraphNode, image: str) -> dict[str, Any]:
    mounts = [
        {"name": _folder_name(site, folder), "mountPath": folder, "readOnly": True}
        for folder in site.folders(node)
    ]
    if site.plan.store:
        mounts.append({"name": "store", "mountPath": str(STORE)})
    container = _container(site, node.id, image, NODE_ROLE, mounts)
    container["env"] += [_secret_key(key) for key in site.keys(node)]
    return {**container, "command": ["python", "-P", "-m", "sceneq_nodes"]}


def _container(
    site: Site, name: str, image: str, role: str, mounts: list[dict[str, Any]]
) -> dict[str, Any]:
    environment = site.environment(name)
    mounted = [
        {"name": "graph", "mountPath": str(CONFIG / GRAPH_FILE), "subPath": GRAPH_FILE},
        {"name": "shm", "mountPath": "/dev/shm"},
        {"name": "tmp", "mountPath": "/tmp"},
        *mounts,
    ]
    if site.encrypted:
        folder = str(CONFIG / "credentials" / role)
        environment["SCENEQ_CREDENTIALS"] = folder
        mounted.append({"name": f"{role}-credentials", "mountPath": folder, "readOnly": True})
    return {
        "name": name.replace("_", "-"),
        "image": image,
        "env": [{"name": key, "value": value} for key, value in environment.items()],
        "volumeMounts": mounted,
        "securityContext": {
            "allowPrivilegeEscalation": False,
            "readOnlyRootFilesystem": True,
            "capabilities": {"drop": ["ALL"]},
        },
    }


def _volumes(site: Site) -> list[dict[str, Any]]:
    volumes: list[dict[str, Any]] = [
        {"name": "graph", "configMap": {"name": _name(site)}},
        {"name": "shm", "emptyDir": {"medium": "Memory", "sizeLimit": SHM}},
        {"name": "tmp", "emptyDir": {}},
    ]
    if site.plan.store:
        claim = {"claimName": f"{_name(site)}-store"}
        volumes.append({"name": "store", "persistentVolumeClaim": claim})
    if site.encrypted:
        for role in (ROUTER_ROLE, NODE_ROLE):
            secret = {"secretName": f"{_name(site)}-{role}", "defaultMode": OWNER_READS}
            volumes.append({"name": f"{role}-credentials", "secret": secret})
    for folder in _folders(site):
        path = {"path": folder, "type": "Directory"}
        volumes.append({"name": _folder_name(site, folder), "hostPath": path})
    return volumes


def _secret_key(key: str) -> dict[str, Any]:
    reference = {"name": "sceneq-keys", "key": key, "optional": True}
    return {"name": key, "valueFrom": {"secretKeyRef": reference}}


def _folders(site: Site) -> list[str]:
    return sorted({folder for node in site.plan.nodes for folder in site.folders(node)})


def _folder_name(site: Site, folder: str) -> str:
    return f"data-{_folders(site).index(folder)}"


def _head(version: str, kind: str, site: Site, name: str = "") -> dict[str, Any]:
    return {"apiVersion": version, "kind": kind, "metadata": _metadata(site, name)}


def _metadata(site: Site, name: str = "") -> dict[str, Any]:
    return {"name": name or _name(site), "labels": _labels(site)}


def _labels(site: Site) -> dict[str, str]:
    return {"app.kubernetes.io/name": "sceneq", MACHINE_LABEL: site.machine}


def _name(site: Site) -> str:
    """Names of Kubernetes have no underscores, those of machines may."""
    return f"sceneq-{site.machine}".replace("_", "-").strip("-")


def _requests(**amounts: str) -> dict[str, Any]:
    return {"requests": amounts}


def _port(port: int, **more: int) -> dict[str, Any]:
    return {"name": f"zenoh-{port}", "port": port, **more}
