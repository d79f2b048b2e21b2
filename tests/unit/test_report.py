"""What a report says, and that its page needs nothing from elsewhere."""

import re
from xml.etree import ElementTree

import pytest

from sceneq_tools.evaluation import report_tables as tables
from sceneq_tools.evaluation.charts import bars, reliability, risk_coverage
from sceneq_tools.evaluation.report_page import page
from sceneq_tools.evaluation.report_tables import Table
from sceneq_tools.evaluation.suite_evaluation import stage_times

COUNTS = {
    "questions": 4,
    "hit_1": 3,
    "hit_5": 4,
    "found": 2,
    "found_right": 2,
    "not_found": 1,
    "unreachable": 0,
    "fast": 1,
    "reasoned": 3,
    "fallback": 0,
    "ms": 2.5,
    "vlm_calls": 7,
}
RETRIEVAL = {
    "split": "test",
    "setting": "configured",
    "protocol": "hit@k",
    "candidates": "map",
    "hit_rule": "IoU >= 0.5",
    "reasoning": "selective",
    "instances": 9,
    "wrongly_not_found": 1,
    "routes": {
        "fast": {"right": 1, "wrong": 0},
        "reasoned": {"right": 2, "wrong": 1},
        "fallback": {"right": 0, "wrong": 0},
    },
    "buckets": [{"bucket": name, **COUNTS} for name in ("category", "all")],
}
SCORES = {"ap": 0.25, "ap50": 0.5, "ap25": None}
PROTOCOLS = [
    {
        **SCORES,
        "protocol": name,
        "rules": "rules",
        "overlaps": [0.5, 0.95, 0.25],
        "min_region": 100,
        "objects": 3,
        "predictions": 5,
        "splits": dict.fromkeys(("head", "common", "tail"), SCORES),
    }
    for name in ("own-labels", "agnostic")
]
INSTANCES = {"protocols": PROTOCOLS, "outside_scannet200": ["chessboard"]}
BINS = [
    {"low": 0.0, "high": 0.2, "count": 3, "confidence": 0.1, "accuracy": 0.0},
    {"low": 0.8, "high": 1.0, "count": 6, "confidence": 0.9, "accuracy": 1.0},
]
F1 = {"f1": 0.5, "precision": 0.4, "recall": 0.3, "accepted": 0.2}
NUDGED = [
    {"threshold": "min_p", "value": 0.5 * f, "factor": f, "score": F1} for f in (0.9, 1.0, 1.1)
]
TASK = {
    "task": "labels: what",
    "choices": "own",
    "guesses": 9,
    "accuracy": 0.667,
    **dict.fromkeys(("confidence", "nll", "brier", "top_brier", "ece_width"), 0.125),
    "ece_mass": 0.25,
    "ece_noise": 0.375,
    "ece_as_much": 0.75,
    "ece_beyond": 0.0625,
    "ece_interval": [0.125, 0.5],
    "aurc": 0.1,
    "least_aurc": 0.05,
    "bins": BINS,
    "auroc": {"p_max": 0.75, "margin": None, "entropy": 0.5},
    "coverage": [0.5, 1.0],
    "risk": [0.0, 0.5],
}
CALIBRATION = {
    "split": "test",
    "setting": "configured",
    "temperature": 0.033,
    "tasks": [TASK],
    **{name: f"says {name}" for name in tables.CALIBRATION_NOTES},
    "routing": {
        "gate": {"min_p": 0.5},
        "decisions": 8,
        "f1": F1,
        "sensitivity": NUDGED,
        "questions": 10,
        "as_routed": F1,
    },
}
RECORDING = {
    "name": "a<b",
    "split": "test",
    "made_by": "g, l",
    "sha256": "0" * 64,
    "frames": 20,
    "keyframes": 10,
    "things": 4,
    "unseen_things": 1,
    "questions": 4,
    "map": {
        "key": "abc",
        "was_there": True,
        "instances": 9,
        "troubles": {"ingest.skipped": 2},
        "taken_ms": {"ingest": 50.0, "mapping": 200.0},
    },
    "instances": INSTANCES,
    "retrieval": [RETRIEVAL],
}
DOCUMENT = {
    "date": "2026-01-02T03:04:05",
    "command": "sceneq eval suite <x>",
    "sceneq": "1",
    "machine": {"cores": 2, "processor": "p"},
    "setup": {"label_set": "own"},
    "segmenter": "rgbd",
    "took_s": 90.0,
    "mapping_s": 30.0,
    "recordings": [RECORDING],
    "instances": {"test": INSTANCES},
    "retrieval": [RETRIEVAL],
    "fitted": None,
    "calibration": [CALIBRATION],
    "ablation": [{"split": "test", "setting": "configured", "results": [RETRIEVAL]}],
    "failures": [
        {
            "recording": "a<b",
            "candidates": "map",
            "hit_rule": "IoU >= 0.5",
            "question": "red <mug>",
            "bucket": "category",
            "status": "found",
            "route": "fast",
            "p": 0.9,
            "answered": None,
            "right": [],
            "reason": "why",
            "pictures": [{"says": "answered", "image": "data:image/jpeg;base64,AA"}],
        }
    ],
}


def rows(table: Table) -> list[dict[str, str]]:
    assert all(len(row) == len(table.columns) for row in table.rows)
    return [dict(zip(table.columns, row, strict=True)) for row in table.rows]


def test_hits_say_of_how_many() -> None:
    assert tables.hit(RETRIEVAL, "category") == "75 % of 4"
    assert tables.hit(RETRIEVAL, "absent") == "-"
    (row,) = rows(tables.retrieval([RETRIEVAL]))
    assert (row["all @1"], row["all @5"], row["fast"]) == ("75 % of 4", "100 % of 4", "25 %")
    (row,) = rows(tables.routes([RETRIEVAL]))
    assert (row["reasoned right"], row["reasoned wrong"], row["wrongly so"]) == ("2", "1", "1")
    (row,) = rows(tables.ablation(DOCUMENT["ablation"]))
    assert (row["reasoning"], row["VLM calls"]) == ("selective", "7")


def test_groups_of_classes_have_no_ap_where_classes_do_not_count() -> None:
    labelled, agnostic = rows(tables.instances_by_split({"test": INSTANCES}))
    assert (labelled["AP"], labelled["AP25"], labelled["head AP"]) == ("0.250", "-", "0.250")
    assert (agnostic["AP50"], agnostic["head AP"]) == ("0.500", "-")
    (row,) = rows(tables.instances_by_recording([RECORDING]))
    assert (row["recording"], row["agnostic AP50"]) == ("a<b", "0.500")
    assert list(tables.protocol_rules({"test": INSTANCES})) == [
        "own-labels: rules; IoU 0.50:0.05:0.95",
        "agnostic: rules; IoU 0.50:0.05:0.95",
        "not in ScanNet200, void in scannet200: chessboard",
    ]


def test_what_to_look_at_first_names_its_protocols() -> None:
    (row,) = rows(tables.summary(DOCUMENT))
    assert row["Hit@1 map, IoU >= 0.5"] == "75 % of 4"
    assert row["Hit@1 true instances, true mask"] == "-"
    assert row["instances: agnostic AP50"] == "0.500"
    (row,) = rows(tables.recordings([RECORDING]))
    assert (row["map"], row["lost or refused"]) == ("abc (was there)", "ingest.skipped 2")


def test_calibration_rows() -> None:
    table = tables.calibration(CALIBRATION)
    assert table.title == "test, configured: T 0.033"
    (row,) = rows(table)
    assert (row["guesses"], row["right"], row["AUROC p"]) == ("labels -> own", "67 %", "0.750")
    assert row["margin"] == "-"
    assert (row["as much"], row["beyond"], row["90 %"]) == ("0.750", "0.062", "0.125 to 0.500")
    assert tables.sensitivity(CALIBRATION["routing"]).rows == (
        ("min_p 0.5", "0.500", "0.500", "0.500"),
    )


def test_stage_times_are_a_mean_over_keyframes() -> None:
    assert stage_times([RECORDING, RECORDING]) == {"ingest": 5.0, "mapping": 20.0}


def test_a_dot_lies_where_its_bin_is() -> None:
    svg = ElementTree.fromstring(reliability(BINS))
    tag = "{http://www.w3.org/2000/svg}circle"
    (low, high) = ((float(c.attrib["cx"]), float(c.attrib["cy"])) for c in svg.iter(tag))
    side = (high[0] - low[0]) / 0.8  # confidence 0.1 and 0.9
    assert low[1] - high[1] == pytest.approx(side, abs=0.2)  # accuracy 0 and 1
    radii = [float(c.attrib["r"]) for c in svg.iter(tag)]
    assert radii == [5.0, 7.0]


def test_charts_are_well_formed_even_of_nothing() -> None:
    for text in (
        reliability([]),
        risk_coverage({"a & b": ([0.5, 1.0], [0.0, 0.5]), "none": ([], [])}),
        bars({"a <b>": 2.0, "c": 0.0}, "ms"),
        bars({}, "ms"),
    ):
        assert ElementTree.fromstring(text).tag.endswith("svg")


def test_the_page_needs_nothing_from_elsewhere_and_escapes_what_it_shows() -> None:
    text = page(DOCUMENT, {"a<b": "data:image/jpeg;base64,BB"})
    for section in ("Recordings", "Instances", "Retrieval", "Routes", "Calibration", "Time"):
        assert f"<h2>{section}</h2>" in text
    assert all(source.startswith("data:") for source in re.findall(r'src="([^"]*)"', text))
    assert set(re.findall(r'https?://[^\s"]+', text)) == {"http://www.w3.org/2000/svg"}
    assert "<script" not in text
    assert "<link" not in text
    assert "sceneq eval suite &lt;x&gt;" in text
    assert "red &lt;mug&gt;" in text
    assert "<mug>" not in text
