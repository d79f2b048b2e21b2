"""The demo on a recording: play it through the graph, ask meanwhile, ask again, draw."""

import re
import sys
import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from textwrap import shorten
from typing import Any

import yaml

from sceneq_core.picture.scene import Mark
from sceneq_schemas.topics import QUERY_ASK
from sceneq_tools import demo_text, scenes
from sceneq_tools.ask_command import REASON_TIMEOUT_S
from sceneq_tools.collect import collect
from sceneq_tools.demo_graph import DemoGraph
from sceneq_tools.demo_truth import Question, Truth, Verdict, questions_of, remark
from sceneq_tools.errors import UserError
from sceneq_tools.evidence import write_evidence
from sceneq_tools.export_command import getter
from sceneq_tools.graph import default_path
from sceneq_tools.rerun_file import write_rerun
from sceneq_tools.scene_files import SceneFiles, describe
from sceneq_tools.scene_picture import box_corners, scene_picture, write_png

KEYFRAMES = 50
"""So many are enough for a look, and quickly in the map."""
SILENT_S = 20.0
"""Patience of the watchdog: whoever tries a demo may have a busy machine."""
SETTLE_S = 300.0
FRAME = re.compile(r"frame-(\d{6})\.depth\.png")
CANDIDATES = 3
FILES, RGBD = "files", "rgbd"
SEGMENTS = {
    FILES: "those that lie beside the frames, mask.png (--segmenter rgbd: the built-in ones)",
    RGBD: "built in, from geometry and colour, without weights",
}
MARK_TEXT = 28

Answer = dict[str, Any]


def sample() -> Path:
    """Return the recording that comes with the project.

    Raises:
        UserError: it is not there.
    """
    folder = Path(__file__).parent / "sample"
    if not folder.is_dir():
        raise UserError(f"{folder}: no sample there (say a folder: sceneq demo FOLDER)", 2)
    return folder


class Demo:
    """One run of the demo.

    Args:
        source: folder of frames.
        out: folder to write into.
        texts: what to ask; nothing = what the folder brings along.
        graph: graph file; ``None`` = the usual one, with keyframes that suit the recording.
        rate_hz: frames a second; 0 = as fast as the graph takes them, none is lost.
        segmenter: files or rgbd; ``None`` = files where the folder has label images.

    Raises:
        UserError: the folder holds no frames, or its truth cannot be read.
    """

    def __init__(
        self,
        source: Path,
        out: Path,
        texts: list[str],
        graph: Path | None,
        rate_hz: float,
        segmenter: str | None = None,
    ) -> None:
        self._source, self._out, self._graph_file = source, out, graph
        found = [FRAME.fullmatch(path.name) for path in source.glob("frame-*")]
        self._numbers = sorted(int(match[1]) for match in found if match)
        if not self._numbers:
            raise UserError(f"{source}: no frames (frame-NNNNNN.depth.png) in it", 2)
        self._rate_hz = rate_hz
        has_masks = next(source.glob("frame-*.mask.png"), None) is not None
        self._segmenter = segmenter or (FILES if has_masks else RGBD)
        self._questions = questions_of(source, texts)
        self._remark = "" if texts else remark(source)
        self._truth = Truth(source)

    def run(self) -> None:
        """Do it all.

        Raises:
            UserError: a node died, a question got no answer, or a file could not be written.
        """
        demo_text.heading(f"Scene-Q on {self._source.name}: {len(self._numbers)} frames")
        with DemoGraph(self._options(), self._out / "graph.log") as graph:
            scene = self._start(graph)
            self._ask_while_it_grows(graph, scene)
            self._settle(graph)
            answers = self._ask_the_whole_map(graph, scene)
            files = collect(getter(graph.client, scene), scene)
            troubles = graph.troubles()
            self._write(files, answers)
            if graph.console and sys.stdout.isatty() and not troubles:
                demo_text.say(f"\nThe map stays: ask it at {graph.console}   (Ctrl-C ends it)")
                graph.stay()
        if troubles:
            raise UserError("not everything went well:\n" + "\n".join(troubles))

    def _options(self) -> list[str]:
        graph = self._graph_file or self.written_graph()
        source = ["--source", str(self._source), "--rate", f"{self._rate_hz:g}"]
        segments = ["--segmenter", self._segmenter]
        return [str(graph), *source, *segments, "--log-dir", str(self._out / "logs")]

    def written_graph(self) -> Path:
        """Write the usual graph with as many keyframes as make a map in half a minute."""
        document = yaml.safe_load(default_path().read_text())
        every = max(1, len(self._numbers) // KEYFRAMES)
        for node in document["nodes"]:
            if node.get("kind", node["id"]) == "ingest":
                keyframes = {"kind": "every", "every": every}
                node.setdefault("params", {})["keyframes"] = keyframes
        document.setdefault("watchdog", {})["silent_s"] = SILENT_S
        self._out.mkdir(parents=True, exist_ok=True)
        path = self._out / "graph.yaml"
        path.write_text(yaml.safe_dump(document, sort_keys=False))
        return path

    def _start(self, graph: DemoGraph) -> str:
        started_s = time.monotonic()
        with demo_text.waiting("starting the graph"):
            graph.connect()
            scene = graph.scene()
        took_s = time.monotonic() - started_s
        rows = [("graph", f"on {graph.endpoint}, something to ask about after {took_s:.1f} s")]
        rows.append(("segments", SEGMENTS.get(self._segmenter, self._segmenter)))
        if graph.console:
            rows.append(("console", f"{graph.console}   (ask in a browser)"))
        if activation := demo_text.activation():
            rows.append(("type", f"along from another shell: {activation}"))
        demo_text.facts(rows)
        return scene

    def _ask_while_it_grows(self, graph: DemoGraph, scene: str) -> None:
        """Put the questions one after the other, spread over the time the recording plays."""
        demo_text.heading("While the map grows")
        total = len(self._numbers)
        for number, question in enumerate(self._questions, 1):
            due = total * number / (len(self._questions) + 1)
            graph.wait(partial(_has_played, graph, due), SETTLE_S, "too few frames were read")
            played = int(graph.value("ingest", "frames"))
            instances = graph.value("mapping", "instances")
            answer = self._ask(graph, scene, question)
            frame = self._numbers[min(max(played, 1), total) - 1]
            verdict = self._truth.verdict(question, answer, frame)
            shell = demo_text.command(graph.endpoint, scene, question.text)
            state = f"{played}/{total} frames, {instances} instances"
            demo_text.in_growing_map(shell, state, answer, verdict)

    def _settle(self, graph: DemoGraph) -> None:
        """Wait until everything seen is described."""
        with demo_text.waiting("describing what was seen"):
            graph.wait(lambda: _is_settled(graph), SETTLE_S, "the map was not described")

    def _ask_the_whole_map(
        self, graph: DemoGraph, scene: str
    ) -> list[tuple[Question, Answer, Verdict]]:
        demo_text.heading("The recording is over: the same questions to the whole map")
        answers = []
        for number, question in enumerate(self._questions, 1):
            answer = self._ask(graph, scene, question)
            verdict = self._truth.verdict(question, answer, self._numbers[-1])
            evidence = self._evidence(graph, number, answer)
            demo_text.in_whole_map(number, question, answer, verdict, evidence)
            answers.append((question, answer, verdict))
        return answers

    def _evidence(self, graph: DemoGraph, number: int, answer: Answer) -> Path | None:
        """Write the views that an answer rests on, ``None`` when it found nothing."""

        def picture(key: str) -> bytes | None:
            replies, _ = graph.client.get(key)
            return replies[-1][1].payload if replies else None

        path = self._out / f"evidence-{number}.png"
        return path if found(answer) and write_evidence(answer, picture, path) else None

    def _ask(self, graph: DemoGraph, scene: str, question: Question) -> Answer:
        request = {"q": question.text, "k": CANDIDATES}
        asked = scenes.ask(graph.client, QUERY_ASK, scene, request, REASON_TIMEOUT_S)
        return asked.body

    def _write(self, files: SceneFiles, answers: list[tuple[Question, Answer, Verdict]]) -> None:
        summary = files.write(self._out)
        write_rerun(files, self._out / "scene.rrd")
        picture = self._out / "answers.png"
        cloud = files.cloud()
        marks = answer_marks(answers)
        write_png(scene_picture(cloud, summary, marks), picture)
        demo_text.heading(demo_text.score([verdict for _, _, verdict in answers]).capitalize())
        demo_text.facts(
            [
                *([("asked", self._remark)] if self._remark else []),
                ("map", describe(summary, self._out)),
                ("picture", f"{picture}"),
                ("look", f"rerun {self._out / 'scene.rrd'}"),
                ("next", "sceneq demo --live   (a simulated robot; move things and ask again)"),
            ]
        )


def found(answer: Answer) -> bool:
    """Tell whether an answer names an instance."""
    return answer.get("status") != "not_found" and bool(answer.get("instances"))


def answer_marks(answers: Sequence[tuple[Question, Answer, Verdict]]) -> list[Mark]:
    """Return a mark for each instance that is the best answer to one or more questions."""
    texts: dict[int, list[str]] = {}
    records: dict[int, Any] = {}
    for number, (question, answer, verdict) in enumerate(answers, 1):
        if found(answer):
            best = answer["instances"][0]
            short = shorten(question.text, MARK_TEXT, placeholder=" …")
            judged = "" if verdict.right is None else (" right" if verdict.right else " wrong")
            texts.setdefault(best["id"], []).append(f"{number} “{short}” p {best['p']:.2f}{judged}")
            records[best["id"]] = best
    return [
        Mark(number, " · ".join(texts[number]), box_corners(best["box_oriented"]))
        for number, best in records.items()
    ]


def _has_played(graph: DemoGraph, frames: float) -> bool:
    finished = graph.value("ingest", "state", "") == "finished"
    return finished or int(graph.value("ingest", "frames")) >= frames


def _is_settled(graph: DemoGraph) -> bool:
    finished = graph.value("ingest", "state", "") == "finished"
    return bool(finished and graph.value("encoding", "pending", None) == 0)
