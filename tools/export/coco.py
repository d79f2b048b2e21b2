"""Boxes of the instances in the keyframes that are evidence for them, in COCO's form.

``images/`` has the keyframes, ``instances.json`` the boxes as [x, y, width, height] in pixels with
the id of the instance in ``attributes`` (https://cocodataset.org/#format-data). A keyframe that is
gone from the graph is left out, and counted in ``info``.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from sceneq_tools.errors import UserError
from sceneq_tools.export.scene import ExportedScene, Picture, Record

Seen = tuple[Record, dict[str, Any]]
"""An instance and one of its views."""


def write_coco(scene: ExportedScene, out: Path) -> list[Path]:
    """Write ``coco/``; raise ``UserError`` without a graph to ask for the keyframes."""
    if scene.picture is None:
        raise UserError("coco: a folder has no keyframes (export from a running graph)", 2)
    folder = out / "coco"
    (folder / "images").mkdir(parents=True, exist_ok=True)
    seen = [(record, view) for record in scene.records for view in record["views"]]
    images = _images(scene.picture, seen, folder / "images")
    categories = {name: n for n, name in enumerate(sorted({str(r["label"]) for r, _ in seen}), 1)}
    kept = [(record, view) for record, view in seen if view["key"] in images]
    document = {
        "info": {"description": scene.name, "views_without_image": len(seen) - len(kept)},
        "images": list(images.values()),
        "categories": [{"id": n, "name": name} for name, n in categories.items()],
        "annotations": list(_annotations(kept, images, categories)),
    }
    path = folder / "instances.json"
    path.write_text(json.dumps(document, indent=1, ensure_ascii=False))
    return [path, *(folder / "images" / image["file_name"] for image in images.values())]


def _images(picture: Picture, seen: list[Seen], folder: Path) -> dict[str, dict[str, Any]]:
    """Write every keyframe once and return COCO's images by the key of the view."""
    images: dict[str, dict[str, Any]] = {}
    for key, seq in dict.fromkeys((view["key"], view["seq"]) for _, view in seen):
        jpeg = picture(key)
        decoded = None if jpeg is None else cv2.imdecode(np.frombuffer(jpeg, np.uint8), 1)
        if jpeg is None or decoded is None:
            continue
        name = f"{seq:06d}.jpg"
        (folder / name).write_bytes(jpeg)
        height, width = decoded.shape[:2]
        images[key] = {"id": len(images) + 1, "file_name": name, "width": width, "height": height}
    return images


def _annotations(
    kept: list[Seen], images: dict[str, dict[str, Any]], categories: dict[str, int]
) -> Iterator[dict[str, Any]]:
    for number, (record, view) in enumerate(kept, 1):
        left, top, right, bottom = view["box_xyxy"]
        yield {
            "id": number,
            "image_id": images[view["key"]]["id"],
            "category_id": categories[str(record["label"])],
            "bbox": [left, top, right - left, bottom - top],
            "area": (right - left) * (bottom - top),
            "iscrowd": 0,
            "attributes": {"instance_id": record["id"], "p": record["p"]},
        }
