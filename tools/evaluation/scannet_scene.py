"""The truth of a ScanNet scene folder, as the benchmark derives it from the annotation files.

``<scene>_vh_clean_2.ply`` holds the evaluation points, ``.segs.json`` the segment of each,
``.aggregation.json`` which segments make an object and its raw name, and the table
``scannetv2-labels.combined.tsv`` (beside the scene or in one of the folders above) the ScanNet200
number of every raw name: the column ``id`` of the first row with that ``raw_category``.
"""

import csv
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from sceneq_core.arrays import Int64
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.ply import read_vertices
from sceneq_tools.evaluation.scannet_text import read_text, truth_of_codes
from sceneq_tools.evaluation.truth import Truth

MESH = "_vh_clean_2.ply"
SEGMENTS = "_vh_clean_2.0.010000.segs.json"
GROUPS = (".aggregation.json", "_vh_clean.aggregation.json")
LABEL_TABLE = "scannetv2-labels.combined.tsv"
FOLDERS_UP = 3
UNKNOWN = 0


def is_scannet(path: Path) -> bool:
    """Tell whether ``path`` is the folder of an annotated scene."""
    return path.is_dir() and any(path.glob(f"*{MESH}"))


def read_scannet(folder: Path) -> Truth:
    """Return points, ScanNet200 labels and object numbers (from 1) of a scene.

    Points of several objects belong to the last. A raw name that the table does not know has
    label 0, which is in no benchmark.

    Raises:
        UserError: a file is missing, or a field of it is missing or malformed; both are named.
    """
    mesh = next(iter(sorted(folder.glob(f"*{MESH}"))), folder / f"{folder.name}{MESH}")
    scene = mesh.name.removesuffix(MESH)
    points_world = read_vertices(mesh)
    segment = _segments(folder / f"{scene}{SEGMENTS}", len(points_world))
    table = _read_label_table(_label_table(folder))
    label, number = _annotated(_groups_file(folder, scene), segment, table)
    truth = truth_of_codes(label, number, str(folder))
    return Truth(points_world, truth.name, truth.number, truth.names, truth.source)


def _segments(path: Path, points: int) -> Int64:
    try:
        segment = np.array(_field(path, _read_json(path), "segIndices"), np.int64)
    except (ValueError, TypeError, OverflowError) as error:
        raise UserError(f"{path}: segIndices: {error}", 2) from error
    if segment.shape != (points,):
        raise UserError(f"{path}: segIndices: {segment.shape}, but the mesh has {points} points", 2)
    return segment


def _annotated(path: Path, segment: Int64, table: Mapping[str, int]) -> tuple[Int64, Int64]:
    label, number = np.zeros(len(segment), np.int64), np.zeros(len(segment), np.int64)
    for place, group in enumerate(_field(path, _read_json(path), "segGroups")):
        where = f"segGroups[{place}]."
        try:
            mine = np.isin(segment, np.array(_field(path, group, "segments", where), np.int64))
            number[mine] = int(_field(path, group, "objectId", where)) + 1
        except (ValueError, TypeError) as error:
            raise UserError(f"{path}: segGroups[{place}]: {error}", 2) from error
        label[mine] = table.get(str(_field(path, group, "label", where)), UNKNOWN)
    return label, number


def _groups_file(folder: Path, scene: str) -> Path:
    paths = [folder / f"{scene}{suffix}" for suffix in GROUPS]
    return next((path for path in paths if path.is_file()), paths[0])


def _label_table(folder: Path) -> Path:
    folders = [folder.absolute(), *folder.absolute().parents][: FOLDERS_UP + 1]
    paths = [one / LABEL_TABLE for one in folders]
    found = next((path for path in paths if path.is_file()), None)
    if found is None:
        raise UserError(f"{folder / LABEL_TABLE}: no such file, nor in the {FOLDERS_UP} above", 2)
    return found


def _read_label_table(path: Path) -> dict[str, int]:
    rows = list(
        csv.DictReader(read_text(path).splitlines(), delimiter="\t", quoting=csv.QUOTE_NONE)
    )
    missing = [c for c in ("raw_category", "id") if not rows or c not in rows[0]]
    if missing:
        raise UserError(f"{path}: no column {missing[0]!r}", 2)
    try:
        # From the last to the first, so that the first row of a name stays.
        return {str(row["raw_category"]): int(row["id"]) for row in reversed(rows)}
    except (ValueError, TypeError) as error:
        raise UserError(f"{path}: column 'id': {error}", 2) from error


def _read_json(path: Path) -> Any:
    try:
        return json.loads(read_text(path))
    except ValueError as error:
        raise UserError(f"{path}: no JSON: {error}", 2) from error


def _field(path: Path, record: Any, name: str, where: str = "") -> Any:
    if not isinstance(record, Mapping) or name not in record:
        raise UserError(f"{path}: {where}{name}: missing", 2)
    value = record[name]
    if name.startswith("seg") and not isinstance(value, Sequence):
        raise UserError(f"{path}: {where}{name}: expected a list", 2)
    return value
