"""Measurements as a table and as JSON, and two runs side by side."""

import json
import os
import platform
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

from sceneq_tools.bench.measurement import Measurement
from sceneq_tools.errors import UserError

SCHEMA = "sceneq.bench.v1"
COLUMNS = ("bench", "what", "value", "beside", "ratio")
Results = Mapping[str, Sequence[Measurement]]
Baseline = Mapping[tuple[str, str, str], Mapping[str, Any]]


def as_json(results: Results) -> dict[str, Any]:
    """Return everything, with the machine it was measured on."""
    return {
        "schema": SCHEMA,
        "sceneq": version("sceneq"),
        "at": datetime.now(UTC).isoformat(timespec="seconds"),
        "machine": machine(),
        "measurements": [
            {
                "bench": bench,
                "name": one.name,
                "value": one.value,
                "unit": one.unit,
                "beside": one.beside,
                "reference": one.reference,
                "ratio": one.ratio,
                **({"series": [round(v, 2) for v in one.series]} if one.series else {}),
            }
            for bench, measured in results.items()
            for one in measured
        ],
    }


def machine() -> dict[str, Any]:
    """Return what the numbers depend on."""
    return {
        "cores": len(os.sched_getaffinity(0)),
        "processor": _processor(),
        "system": f"{platform.system()} {platform.release()}",
        "python": platform.python_version(),
    }


def read_baseline(path: Path) -> Baseline:
    """Return the measurements of an earlier run by (bench, name, unit).

    Raises:
        UserError: not a file that ``sceneq bench --json`` wrote.
    """
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        if document["schema"] != SCHEMA:
            raise UserError(f"{path}: schema {document['schema']!r}, expected {SCHEMA!r}", 2)
        measured = document["measurements"]
        return {(one["bench"], one["name"], one["unit"]): one for one in measured}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: not written by `sceneq bench --json`: {error}", 2) from error


def rows(results: Results, baseline: Baseline | None = None) -> Iterator[tuple[str, ...]]:
    """Yield the cells of every measurement; with a baseline, how it compares."""
    for bench, measured in results.items():
        for one in measured:
            cells = bench, one.name, f"{figures(one.value)} {one.unit}", *_beside(one)
            yield cells if baseline is None else (*cells, compared(bench, one, baseline))


def compared(bench: str, now: Measurement, baseline: Baseline) -> str:
    """Say how much better or worse than then; by ratios, so that machines may differ."""
    then = baseline.get((bench, now.name, now.unit))
    if then is None:
        return "new"
    ours, theirs = now.ratio, then["ratio"]
    if ours is None or theirs is None:
        ours, theirs = now.value, then["value"]
    if not ours or not theirs:
        return "same" if ours == theirs else f"was {figures(theirs)}"
    gain = ours / theirs if now.more_is_better else theirs / ours
    return f"{gain:.2f}x better" if gain >= 1 else f"{1 / gain:.2f}x worse"


def figures(value: float) -> str:
    """Return three figures, and all before the point."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def _beside(one: Measurement) -> tuple[str, str]:
    if one.reference is None or one.ratio is None:
        return "", ""
    return f"{one.beside}: {figures(one.reference)}", f"{figures(one.ratio)}x"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
