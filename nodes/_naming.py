"""The queryable that names one instance."""

from collections.abc import Callable
from dataclasses import replace

from sceneq_core.reasoning.reasoner import LabelProblem, LabelVerdict, UnansweredError
from sceneq_core.routing.answer import REASONED, Naming
from sceneq_core.routing.namer import Namer, OtherLabels
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_nodes._answer_json import naming_json
from sceneq_nodes._ask import DEFAULT_K, Ask, label_names, left_s, read_ask, reply
from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._look import Look
from sceneq_nodes._scene_pages import USAGE
from sceneq_nodes._stopwatch import Stopwatch


def nobody(problem: LabelProblem) -> LabelVerdict:
    """Say that there is no reasoner: raises ``UnansweredError``."""
    raise UnansweredError("no reasoner names things here")


def nobody_listens(naming: Naming) -> None:
    """Forget it."""


class NamingDesk:
    """Answers ``label``; ``told`` hears what a reasoner calls things by the scene's labels."""

    def __init__(
        self,
        scene: str,
        names: OtherLabels,
        look: Callable[[], Look],
        reason: Callable[[LabelProblem], LabelVerdict] = nobody,
        told: Callable[[Naming], None] = nobody_listens,
    ) -> None:
        self._scene = scene
        self._names = names
        self._look = look
        self._reason = reason
        self._told = told

    def label(self, request: Request) -> Reply | None:
        """Name one instance."""
        watch, ask, look = Stopwatch(), read_ask(request), self._look()
        if request.wildcard or ask.instance_id is None:
            usage = reply({"usage": USAGE["label"]}, "usage", ask.fmt)
            return None if request.wildcard and ask.text else usage
        row, k = look.row(ask.instance_id, self._scene), ask.k or DEFAULT_K
        namer = self._namer(ask)
        watch.lap("text")
        naming = namer.label(look.snapshot, row, k)
        watch.lap("search")
        if ask.mode == "reason":
            time_s = left_s(ask, watch.total_ms())
            naming = self._think(namer, look.snapshot, row, naming, time_s)
            watch.lap("reason")
        if naming.route == REASONED and namer is self._names.namer(()):
            self._told(naming)
        return reply(naming_json(naming, look.stamp(self._scene, watch)), "label", ask.fmt)

    def _namer(self, ask: Ask) -> Namer:
        try:
            return self._names.namer(ask.labels or label_names(ask.text))
        except ValueError as error:
            raise QueryError("bad_request", str(error), "try ?id=7;labels=mug,cup,bowl") from error

    def _think(
        self, namer: Namer, snapshot: SceneSnapshot, row: int, naming: Naming, time_s: float
    ) -> Naming:
        """Let the reasoner look at the thing; when it cannot, the encoder's name has to do."""
        problem = replace(namer.problem(snapshot, row), time_s=time_s)
        try:
            verdict = self._reason(problem)
            return namer.conclude(snapshot, row, verdict, len(naming.labels))
        except UnansweredError as error:
            return namer.fall_back(naming, str(error), error.vlm_calls, error.usage)
        except ValueError as error:
            return namer.fall_back(naming, str(error))
