"""How each command of the documents is run by the tests; one that no row knows fails."""

import re
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from support.documents import ROOT, Command


class Way(Enum):
    """Who runs a command, and beside what."""

    ALONE = "typed, to its end"
    BESIDE = "typed to its end beside the running graph"
    STAYS = "started, waited for, ended by Ctrl-C"
    STORY = "part of a story of several commands, each run in it"
    ELSEWHERE = "run by another test, which is named"
    PARSED = "read by our command line, not run: it takes too long, and parts of it run elsewhere"
    MAKE = "make -n: make itself runs in CI"


@dataclass(frozen=True)
class Row:
    """``pattern`` finds commands; ``detail`` is the test, or the reason."""

    pattern: str
    way: Way
    detail: str = ""


ROWS = (
    Row(r"make (demo|test|furniture|site)\b", Way.MAKE, "CI runs make test, with test_demo.py"),
    Row(r"pip install ", Way.ALONE, "pip's dry run; extras and packages are known"),
    # questions.md and the examples have tests of their own
    Row(
        r"zenoh .*query/house/(ask|label)\?.*json$", Way.ELSEWHERE, "integration/test_questions.py"
    ),
    # stories: what they need from each other is in test_documents.py
    Row(r"sceneq demo --live", Way.STORY, "live_demo"),
    Row(r"sceneq sim ", Way.ELSEWHERE, "integration/test_live_sim.py"),
    Row(r"sceneq up --without ingest", Way.STORY, "running_graph"),
    Row(r"sceneq replay run.mcap", Way.STORY, "running_graph"),
    Row(r"sceneq import SOURCE run.mcap", Way.STORY, "running_graph"),
    Row(
        r"sceneq secure (init site --graph|issue site ros)", Way.ELSEWHERE, "unit/test_security.py"
    ),
    Row(r"sceneq (secure|up --secure)", Way.STORY, "secured"),
    Row(r"SCENEQ_CREDENTIALS=", Way.STORY, "secured"),
    Row(r"zenoh .*--connect tls/", Way.STORY, "secured"),
    Row(r"sceneq up --source ros2:/camera/color", Way.STORY, "robot"),
    Row(r"python docs/examples/play_as_robot.py", Way.STORY, "robot"),
    Row(r"sceneq scene (drop|list --store store)", Way.ELSEWHERE, "nodes/test_left_visits.py"),
    Row(r"sceneq scene merge|sceneq scene info house", Way.ELSEWHERE, "unit/test_scene_merge.py"),
    Row(r"sceneq (up|check|render) graph.yaml", Way.STORY, "machines"),
    Row(r"sceneq (status --watch|metrics --serve)", Way.STORY, "running_graph"),
    Row(r"sceneq doctor", Way.STORY, "doctor"),
    Row(r"sceneq (trace|record|viewer)\b", Way.STORY, "running_graph"),
    Row(r"sceneq up\b", Way.STAYS),
    Row(r"sceneq (ask|status|metrics|view|teach|forget)\b", Way.BESIDE),
    Row(r"sceneq export \S+( |$)(?!.*--from)", Way.BESIDE),
    Row(r"(zenoh|curl) ", Way.BESIDE),
    Row(r"sceneq bench --help", Way.ALONE),
    Row(r"sceneq bench\b", Way.PARSED, "integration/test_bench.py"),
    Row(r"sceneq chaos (--short|fuzz)", Way.ELSEWHERE, "integration/test_chaos.py"),
    Row(r"sceneq chaos\b", Way.PARSED, "integration/test_chaos.py"),
    Row(r"sceneq synth .*--suite", Way.ALONE),
    Row(r"sceneq (portraits|train-probe)\b", Way.PARSED, "integration/test_train_probe.py"),
    Row(r"sceneq (map|export|import|scene|eval|calibrate|calibrate-names)\b", Way.ALONE),
)


def row_of(command: Command) -> Row:
    """Return how a command is run; raise ``LookupError`` where nobody has said."""
    text = command.text.split("  #")[0].rstrip()
    for row in ROWS:
        if re.match(row.pattern, text, re.S):
            return row
    raise LookupError(f"{command.where}: nobody has said how to run {command.text!r}")


def elsewhere(row: Row) -> Path:
    """Return the test that a row names."""
    return ROOT / "tests" / row.detail
