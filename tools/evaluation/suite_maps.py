"""Maps of recordings, kept beside each other: what was mapped before is not mapped again.

A map is the same when the recording, the parameters of the nodes and the code that makes maps are
the same: a number from an older mapper would be a wrong number.
"""

import hashlib
import json
import time
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sceneq_tools.evaluation.suite_recordings import Recording, frames_digest

if TYPE_CHECKING:
    from sceneq_tools.graph_plan import Plan

RECORD_FILE = "made.json"
MAKERS = ("sceneq_core", "sceneq_nodes", "sceneq_schemas")
NOT_MAKERS = "evaluation"
KEY_DIGITS = 16
SHEET_SIZE = (960, 600)
"""Of the picture of a map, pixels: enough for a report, and much faster drawn than a large one."""


@dataclass(frozen=True, slots=True)
class Mapped:
    """A map in ``folder``.

    Attributes:
        folder: as ``sceneq map`` writes it.
        key: of everything it was made from.
        frames: played; ``keyframes`` of them are in the map.
        taken_ms: of each stage (``bench.stages``), in all, when the map was made.
        took_s: to make it, reading and writing included.
        troubles: counters of what was lost or refused.
        was_there: it was made by an earlier run.
    """

    folder: Path
    key: str
    frames: int
    keyframes: int
    taken_ms: dict[str, float]
    took_s: float
    troubles: dict[str, int]
    was_there: bool


@dataclass(frozen=True, slots=True)
class MapOptions:
    """``graph`` file, ``None`` = the usual one; ``segmenter`` kind, ``None`` = as the graph says;
    ``cache`` where maps are kept; ``fresh``: make them again."""

    cache: Path
    graph: Path | None = None
    segmenter: str | None = None
    fresh: bool = False


def mapped(recording: Recording, options: MapOptions, quiet: bool = False) -> Mapped:
    """Return the map of a recording, made now unless it is there.

    Raises:
        UserError: a graph that cannot be used, or a recording that cannot be read.
    """
    plan = _plan(recording, options)
    key = _key(plan, recording)
    folder = options.cache / f"{recording.name}-{key}"
    record = folder / RECORD_FILE
    was_there = record.is_file() and not options.fresh
    if not was_there:
        record.unlink(missing_ok=True)
        made = _make(plan, recording.name, folder, quiet)
        record.write_text(json.dumps(made, indent=1) + "\n")
    return Mapped(folder, key, **json.loads(record.read_text()), was_there=was_there)


def _plan(recording: Recording, options: MapOptions) -> "Plan":
    """Return the same plan as ``sceneq map`` makes, with the recording's keyframes."""
    from sceneq_tools.map_plan import map_plan

    return map_plan(
        *(recording.folder, options.graph, recording.name),
        step=recording.every,
        segmenter=options.segmenter,
    )


def _key(plan: "Plan", recording: Recording) -> str:
    params = {node.id: [node.node_kind, node.params] for node in plan.nodes}
    said = json.dumps(params, sort_keys=True, default=str)
    anywhere = said.replace(str(recording.folder.resolve()), "RECORDING")
    parts = (frames_digest(recording.folder), anywhere, code_digest())
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:KEY_DIGITS]


@cache
def code_digest() -> str:
    """Return the SHA-256 of the code that makes maps, as it was when first asked for."""
    digest = hashlib.sha256()
    for name, path in _sources():
        digest.update(name.encode() + path.read_bytes())
    return digest.hexdigest()


def _sources() -> Iterable[tuple[str, Path]]:
    from importlib.util import find_spec

    for package in MAKERS:
        spec = find_spec(package)
        for root in (spec and spec.submodule_search_locations) or ():
            for path in sorted(Path(root).rglob("*.py")):
                inside = path.relative_to(root)
                if inside.parts[0] != NOT_MAKERS:
                    yield f"{package}/{inside}", path


def _make(plan: "Plan", name: str, folder: Path, quiet: bool) -> dict[str, Any]:
    """Write the map; return how that went."""
    from sceneq_tools.batch import Batch
    from sceneq_tools.bench.stages import KEYFRAME, KEYFRAMES, NODES, PARTS
    from sceneq_tools.bench.stopwatch import Stopwatch
    from sceneq_tools.collect import collect
    from sceneq_tools.playing import play

    stopwatch, start_s = Stopwatch(), time.perf_counter()
    with stopwatch.watching({**NODES, **PARTS, **KEYFRAMES}):
        batch = Batch(plan)
        try:
            frames = play(batch.stages(), quiet, f"mapping {name}: ")
            collect(batch.get, batch.scene).write(folder, SHEET_SIZE)
            troubles = batch.troubles()
        finally:
            batch.close()
    return {
        "frames": frames,
        "keyframes": len(stopwatch.taken_ms.pop(KEYFRAME)),
        "taken_ms": {stage: round(sum(ms), 1) for stage, ms in stopwatch.taken_ms.items()},
        "took_s": round(time.perf_counter() - start_s, 1),
        "troubles": troubles,
    }
