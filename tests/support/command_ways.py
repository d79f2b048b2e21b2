"""How each command of the documents is run by the tests; one that no row knows fails."""

import re
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from support.documents import ROOT, Command, commands, pages


class Way(Enum):
    """Who runs a command, and beside what."""

    ALONE = "typed, to its end"
    BESIDE = "typed to its end beside the running graph"
    STAYS = "started, waited for, ended by Ctrl-C"
    STORY = "part of a story of several commands, each run in it"
    ELSEWHERE = "run by another test, which is named"
    SHORTENED = "typed with more options, which make it short, by the test that is named"
    MAKE = "make -n: make itself runs in CI"


@dataclass(frozen=True)
class Row:
    """``pattern`` finds commands; ``detail`` is the test, or the reason.

    ``more``: what is typed behind a command so that it takes seconds.
    """

    pattern: str
    way: Way
    detail: str = ""
    more: str = ""


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
    # minutes of samplings, hundreds of keyframes: asserted is what is measured, not how fast it is
    Row(r"sceneq bench\b", Way.SHORTENED, "integration/test_bench.py", "--frames 4 --seconds 0.02"),
    # ten minutes, a million inputs: all decoders, and the short list of faults
    Row(r"sceneq chaos fuzz", Way.SHORTENED, "integration/test_chaos.py", "--short --count 730"),
    Row(r"sceneq chaos\b", Way.SHORTENED, "integration/test_chaos.py", "--short"),
    Row(r"sceneq synth .*--suite", Way.ALONE),
    # an hour of portraits and of lessons
    Row(
        *(r"sceneq portraits\b", Way.SHORTENED, "integration/test_train_probe.py"),
        more="--rooms 1 --models 2 --views 1",
    ),
    Row(r"sceneq train-probe\b", Way.SHORTENED, "integration/test_train_probe.py", "--rounds 3"),
    Row(
        *(r"sceneq calibrate .*--strangers", Way.SHORTENED, "integration/test_train_probe.py"),
        more="--graph graph.yaml",
    ),
    Row(r"sceneq (map|export|import|scene|eval|calibrate|calibrate-names)\b", Way.ALONE),
)


def row_of(command: Command) -> Row:
    """Return how a command is run; raise ``LookupError`` where nobody has said."""
    for row in ROWS:
        if re.match(row.pattern, _bare(command), re.S):
            return row
    raise LookupError(f"{command.where}: nobody has said how to run {command.text!r}")


def shortened(test: str) -> list[Command]:
    """Return the commands that a test types with more behind them; each once.

    ``test``: its file, as it calls itself.
    """
    name = Path(test).resolve().relative_to(ROOT / "tests").as_posix()
    typed = (command for page in pages() for command in commands(page))
    found = (c for c in typed if row_of(c) in _rows_of(Way.SHORTENED, name))
    return list({_bare(command): command for command in found}.values())


def _bare(command: Command) -> str:
    """Return a command without the remark behind it."""
    return command.text.partition("  #")[0].rstrip()


def _rows_of(way: Way, name: str) -> list[Row]:
    return [row for row in ROWS if row.way is way and row.detail == name]
