"""Predicted instances in ScanNet's text form, over the points of ``cloud.ply`` beside it.

``SCENE.txt`` has a line ``predicted_masks/SCENE_000.txt CLASS SCORE`` for each instance, and the
mask a line 0 or 1 for each vertex (ScanNet benchmark, 3D semantic instance). Classes have the
numbers of ScanNet200, other labels the next free ones; ``labels.json`` has them all.
"""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Int64
from sceneq_core.evaluation.scannet200_ids import LABELS
from sceneq_tools.export.scene import ExportedScene
from sceneq_tools.ply_file import write_ply

MASKS = "predicted_masks"


def write_scannet(scene: ExportedScene, out: Path) -> list[Path]:
    """Write ``scannet/``: points, one mask per object, and what each is."""
    folder = out / "scannet"
    (folder / MASKS).mkdir(parents=True, exist_ok=True)
    objects = [(r, rows) for r, rows in scene.rows() if r.get("role", "object") == "object"]
    number = class_numbers(str(record["label"]) for record, _ in objects)
    lines = []
    for place, (record, rows) in enumerate(objects):
        name = f"{MASKS}/{scene.name}_{place:03d}.txt"
        _write_mask(folder / name, rows, len(scene.cloud.points_world))
        lines.append(f"{name} {number[str(record['label'])]} {record['p']:.4f}\n")
    listing = folder / f"{scene.name}.txt"
    listing.write_text("".join(lines))
    (folder / "labels.json").write_text(json.dumps({str(n): name for name, n in number.items()}))
    write_ply(folder / "cloud.ply", scene.cloud.points_world, scene.cloud.rgb)
    return [listing, folder / "labels.json", folder / "cloud.ply"]


def class_numbers(labels: Iterable[str]) -> dict[str, int]:
    """Return the class number of every label."""
    known = {name: number for number, name in LABELS.items()}
    own = sorted(set(labels) - set(known))
    return known | {label: number for number, label in enumerate(own, max(LABELS) + 1)}


def _write_mask(path: Path, rows: Int64, count: int) -> None:
    mask = np.full((count, 2), ord("\n"), np.uint8)
    mask[:, 0] = ord("0")
    mask[rows, 0] = ord("1")
    path.write_bytes(mask.tobytes())
