"""Instances as a table, for spreadsheets and scripts."""

import csv
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sceneq_tools.export.scene import ExportedScene, Record

PLAIN = ("id", "label", "label_p", "p", "role", "state", "supported_by", "inside")
TIMES = ("first_seen_ns", "last_seen_ns")
AXES = "xyz"
COLUMNS = (
    *PLAIN,
    *(f"centre_{axis}_m" for axis in AXES),
    *(f"min_{axis}_m" for axis in AXES),
    *(f"max_{axis}_m" for axis in AXES),
    *TIMES,
    "points",
)


def write_csv(scene: ExportedScene, out: Path) -> list[Path]:
    """Write ``instances.csv``: a line for every instance, metres in the scene's frame."""
    points = {record["id"]: len(rows) for record, rows in scene.rows()}
    path = out / "instances.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file)
        table.writerow(COLUMNS)
        table.writerows([*_cells(r), points.get(r["id"], 0)] for r in scene.records)
    return [path]


def _cells(record: Record) -> Iterator[Any]:
    yield from (record.get(name) for name in PLAIN)
    yield from record["centre"]
    yield from record["box_aabb"]["min"]
    yield from record["box_aabb"]["max"]
    yield from (record.get(name) for name in TIMES)
