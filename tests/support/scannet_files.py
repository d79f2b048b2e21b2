"""Writes annotated ScanNet scenes of a few points, in the exact formats of the data set."""

import json
import struct
from pathlib import Path

import numpy as np

POINTS = np.array([[x, y, 0.5] for y in range(3) for x in range(10)], np.float32)
SEGMENTS = [0] * 10 + [5] * 6 + [7] * 4 + [9] * 10
GROUPS = [
    {"id": 0, "objectId": 0, "segments": [0], "label": "wall"},
    {"id": 1, "objectId": 1, "segments": [5, 7], "label": "Office Chair"},
]
TABLE = (
    "id\traw_category\tcategory\tcount\tnyu40id\n"
    "1\twall\twall\t8277\t1\n"
    "10\tOffice Chair\toffice chair\t50\t5\n"
    '99\t12" tube\ttube\t1\t40\n'
)
CODES = [1001] * 10 + [10002] * 10 + [0] * 10
"""What the files above say about the points."""


def write_scene(scans: Path, name: str = "scene0000_00", groups: list | None = None) -> Path:
    """Write a scene into ``scans/name`` and the label table beside it."""
    folder = scans / name
    folder.mkdir(parents=True)
    write_ply(folder / f"{name}_vh_clean_2.ply", POINTS)
    segments = {"sceneId": name, "segIndices": SEGMENTS}
    (folder / f"{name}_vh_clean_2.0.010000.segs.json").write_text(json.dumps(segments))
    document = {"sceneId": name, "segGroups": GROUPS if groups is None else groups}
    (folder / f"{name}.aggregation.json").write_text(json.dumps(document))
    (scans / "scannetv2-labels.combined.tsv").write_text(TABLE)
    return folder


def write_ply(path: Path, points: np.ndarray) -> None:
    """Write vertices as ScanNet does: floats, then colour with alpha, then one face."""
    head = (
        "ply\nformat binary_little_endian 1.0\ncomment VCGLIB generated\n"
        f"element vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
    body = b"".join(struct.pack("<3f4B", *point, 9, 8, 7, 255) for point in points)
    path.write_bytes(head.encode() + body + struct.pack("<B3i", 3, 0, 1, 2))


def write_masks(path: Path, masks: list[tuple[np.ndarray, int, float]]) -> Path:
    """Write a list of (mask, label number, score) and the files it names."""
    folder = path.parent / "masks"
    folder.mkdir(parents=True, exist_ok=True)
    lines = []
    for number, (mask, label, score) in enumerate(masks):
        name = f"{path.stem}_{number:03d}.txt"
        (folder / name).write_text("\n".join(str(int(value)) for value in mask) + "\n")
        lines.append(f"masks/{name} {label} {score}\n")
    path.write_text("".join(lines))
    return path


def write_codes(path: Path, codes: list[int]) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(map(str, codes)) + "\n")
    return path
