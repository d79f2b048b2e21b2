"""The scene graph in node-link form: ``networkx.node_link_graph(data, edges="edges")`` reads it."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sceneq_tools.export.scene import ExportedScene, Record, node_name

SAID_OF_NODE = ("label", "label_p", "role", "state", "centre", "box_aabb", "box_oriented")
ON, IN, NEXT_TO = "on", "in", "next to"


def write_graph(scene: ExportedScene, out: Path) -> list[Path]:
    """Write ``scene_graph.json``: instances, and which is on, in or next to which."""
    known = {record["id"] for record in scene.records}
    graph = {
        "directed": True,
        "multigraph": True,
        "graph": {
            "scene": scene.name,
            "up_world": scene.document["up_world"],
            "unit": "m",
        },
        "nodes": [_node(record) for record in scene.records],
        "edges": [edge for r in scene.records for edge in _edges(r) if edge["target"] in known],
    }
    path = out / "scene_graph.json"
    path.write_text(json.dumps(graph, indent=1, ensure_ascii=False))
    return [path]


def _node(record: Record) -> dict[str, Any]:
    said = {name: record[name] for name in SAID_OF_NODE if name in record}
    return {"id": record["id"], "name": node_name(record), **said}


def _edges(record: Record) -> Iterator[dict[str, Any]]:
    """Yield what an instance has to do with others; next to each other is said once."""
    source = record["id"]
    for kind, target in ((ON, record.get("supported_by")), (IN, record.get("inside"))):
        if target:
            yield {"source": source, "target": target, "key": kind}
    for target in record.get("neighbours", ()):
        if source < target:
            yield {"source": source, "target": target, "key": NEXT_TO}
