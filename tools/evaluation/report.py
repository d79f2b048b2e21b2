"""A report of everything: report.json, report.html, and the calibration that was fitted."""

import json
import time
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from sceneq_core.arrays import Array
from sceneq_tools.bench.report import machine
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.report_failures import data_uri, failure_record, worst
from sceneq_tools.evaluation.report_page import page
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.suite_evaluation import Evaluation, evaluate
from sceneq_tools.evaluation.suite_maps import MapOptions
from sceneq_tools.evaluation.suite_recordings import Recording
from sceneq_tools.evaluation.suite_scene import Asked, SuiteScene, read_suite_scene
from sceneq_tools.progress import progress

SCHEMA = "sceneq.report.v1"
JSON_FILE, PAGE_FILE, CALIBRATION_FILE = "report.json", "report.html", "calibration.json"
SHEET_FILE, SHEET_WIDTH_PX = "instances.png", 800
AS_CONFIGURED = "as the graph says"
Json = dict[str, Any]


def make_report(
    recordings: Sequence[Recording],
    setup: Setup,
    options: MapOptions,
    command: str,
    quiet: bool = False,
) -> tuple[Json, Evaluation]:
    """Map, read and measure ``recordings``; return the document and what it was made from.

    Raises:
        UserError: something is missing or malformed.
    """
    start_s = time.perf_counter()
    scenes = []
    with progress("recordings", len(recordings), "recordings", quiet) as advance:
        for recording in recordings:
            scenes.append(read_suite_scene(recording, setup, options, quiet))
            advance()
    with progress("measuring", None, quiet=quiet):
        evaluation = evaluate(scenes, setup)
        failures = [
            failure_record(one) for kind in _kinds(evaluation) for one in worst(kind, setup)
        ]
    document = {
        "schema": SCHEMA,
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": command,
        "sceneq": version("sceneq"),
        "machine": machine(),
        "setup": setup.named(),
        "segmenter": options.segmenter or AS_CONFIGURED,
        "took_s": round(time.perf_counter() - start_s, 1),
        "mapping_s": round(sum(one.mapped.took_s for one in scenes if not one.mapped.was_there), 1),
        **evaluation.document,
        "failures": failures,
    }
    return document, evaluation


def write_report(document: Json, evaluation: Evaluation, out: Path) -> None:
    """Write all files; ``UserError`` when one cannot be written.

    report.json has everything but the pictures.
    """
    failures = [{**one, "pictures": len(one["pictures"])} for one in document["failures"]]
    texts = {
        JSON_FILE: json.dumps({**document, "failures": failures}, indent=1, ensure_ascii=False),
        PAGE_FILE: page(document, sheets(evaluation.scenes)),
    }
    if evaluation.fitted is not None:
        said = {**evaluation.fitted.as_dict(), "date": document["date"][:10]}
        texts[CALIBRATION_FILE] = json.dumps(said, indent=1)
    try:
        out.mkdir(parents=True, exist_ok=True)
        for name, text in texts.items():
            (out / name).write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"{error.filename}: {error.strerror}") from error


def sheets(scenes: Sequence[SuiteScene]) -> dict[str, str]:
    """Return the pictures that were written with the maps, as data URIs, by recording."""
    found = {}
    for scene in scenes:
        image: Array | None = cv2.imread(str(scene.mapped.folder / SHEET_FILE))
        if image is not None:  # an empty map has none
            found[scene.recording.name] = data_uri(image.astype(np.uint8), SHEET_WIDTH_PX)
    return found


def _kinds(evaluation: Evaluation) -> list[list[Asked]]:
    """Return the answers about true instances, and about maps by the most generous rule.

    By a strict rule, the right thing with a poor mask would count as the wrong thing.
    """
    last = {one.candidates.name: one.retrieval.hit_rule for one in evaluation.asked}
    return [
        [one for one in evaluation.asked if (one.candidates.name, one.retrieval.hit_rule) == kind]
        for kind in last.items()
    ]
