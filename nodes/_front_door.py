"""The queryables of a scene: every handler answers from one immutable snapshot."""

import math
import time
import uuid
from collections import Counter, deque
from collections.abc import Callable
from dataclasses import dataclass, replace

from sceneq_core.mapping.delta import Instance
from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    Problem,
    UnansweredError,
    Verdict,
)
from sceneq_core.routing.answer import Answer, Naming
from sceneq_core.routing.question import Question
from sceneq_core.routing.router import MAX_MATCHES, Routed, Router
from sceneq_core.routing.scene import SceneInstance, SceneSnapshot
from sceneq_nodes._answer_json import (
    Json,
    Stamp,
    answer_json,
    listing_json,
    map_json,
    naming_json,
)
from sceneq_nodes._ask import DEFAULT_K, Ask, read_ask, reply
from sceneq_nodes._bus import QueryError, Reply, Request

MAX_LISTED = 500
LAST = 16
LAST_WHOLE = 3
TOP_LABELS = 20
MAX_SHOWN_CHARS = 80

USAGE = {
    "instances": "?q=red mug (or the question as payload); k=5; fmt=json|msgpack; without q: "
    "?id=7 one instance, ?k=100;after=0 a page of the list",
    "ask": "?q=the mug on the table; may call the reasoner; mode=fast|reason; k=5; "
    "deadline_ms=3000",
    "label": "?id=7: what the instance is called, with probabilities; k=5; mode=reason asks the "
    "reasoner; deadline_ms=3000",
}


@dataclass(frozen=True, slots=True)
class Look:
    """The newest snapshot and when its map arrived, on the clock of ``time.monotonic``."""

    snapshot: SceneSnapshot
    map_arrived_s: float


def _nobody(problem: LabelProblem) -> LabelVerdict:
    raise UnansweredError("no reasoner names things here")


class FrontDoor:
    """Answers ``instances``, ``ask``, ``label``, ``status``, ``labels`` and ``last``."""

    def __init__(
        self,
        scene: str,
        router: Router,
        look: Callable[[], Look],
        reason: Callable[[Problem], Verdict],
        health: Callable[[], Json],
        name: Callable[[LabelProblem], LabelVerdict] = _nobody,
    ) -> None:
        self._scene = scene
        self._router = router
        self._look = look
        self._reason = reason
        self._health = health
        self._name = name
        self._last: deque[Json] = deque(maxlen=LAST)
        self._last_whole: deque[Json] = deque(maxlen=LAST_WHOLE)

    def instances(self, request: Request) -> Reply | None:
        """Rank instances by a question, always at once; without one list them or explain."""
        watch, ask, look = Stopwatch(), read_ask(request), self._look()
        if ask.text:
            question = self._read(ask.text)
            watch.lap("text")
            answer = self._router.answer(look.snapshot, question).answer
            watch.lap("search")
            return self._tell(ask, answer, look, watch)
        if request.wildcard or (ask.k is None and ask.instance_id is None):
            return reply(self._overview(look), "usage", ask.fmt)
        return reply(self._listing(ask, look, watch), "instances", ask.fmt)

    def ask(self, request: Request) -> Reply | None:
        """Answer a question; the reasoner decides what the encoder cannot."""
        watch, ask, look = Stopwatch(), read_ask(request), self._look()
        if not ask.text:
            return reply({"usage": USAGE["ask"]}, "usage", ask.fmt)
        if request.wildcard and ask.mode != "reason":
            return None
        question = self._read(ask.text)
        watch.lap("text")
        routed = self._router.answer(look.snapshot, question)
        watch.lap("search")
        answer = routed.answer
        if routed.problem and (ask.mode == "reason" or (not routed.enough and ask.mode != "fast")):
            problem = replace(routed.problem, time_s=_left_s(ask, watch))
            answer = self._think(look.snapshot, routed, problem)
            watch.lap("reason")
        return self._tell(ask, answer, look, watch)

    def label(self, request: Request) -> Reply | None:
        """Name one instance."""
        watch, ask, look = Stopwatch(), read_ask(request), self._look()
        if request.wildcard or ask.instance_id is None:
            usage = reply({"usage": USAGE["label"]}, "usage", ask.fmt)
            return None if request.wildcard and ask.text else usage
        row, k = self._row(look, ask.instance_id), ask.k or DEFAULT_K
        naming = self._router.label(look.snapshot, row, k)
        watch.lap("search")
        if ask.mode == "reason":
            naming = self._think_of_name(look.snapshot, row, naming, _left_s(ask, watch))
            watch.lap("reason")
        return reply(naming_json(naming, self._stamp(look, watch)), "label", ask.fmt)

    def status(self, request: Request) -> Reply | None:
        """How the scene and its nodes are."""
        ask = read_ask(request)
        if request.wildcard and ask.text:
            return None
        return reply({**self._scene_json(self._look()), **self._health()}, "status", ask.fmt)

    def labels(self, request: Request) -> Reply | None:
        """What things may be called, and how often which name was given."""
        ask = read_ask(request)
        if request.wildcard and ask.text:
            return None
        label_set = self._router.labeller.label_set
        body: Json = {
            "scene": self._scene,
            "label_set": label_set.name,
            "count": len(label_set),
            "given": self._given(self._look(), len(label_set) if ask.k else TOP_LABELS),
        }
        if not request.wildcard:
            body["labels"] = list(label_set.labels)
        return reply(body, "labels", ask.fmt)

    def last(self, request: Request) -> Reply | None:
        """The last answers in short, or with ``k`` the last few as they were given."""
        ask = read_ask(request)
        if request.wildcard and ask.text:
            return None
        kept = self._last if ask.k is None else self._last_whole
        answers = list(kept)[::-1][: ask.k]
        return reply({"scene": self._scene, "answers": answers}, "last", ask.fmt)

    def _read(self, text: str) -> Question:
        try:
            return self._router.read(text)
        except ValueError as error:
            raise QueryError(
                "bad_request", str(error), "ask for a thing, such as red mug"
            ) from error

    def _think(self, snapshot: SceneSnapshot, routed: Routed, problem: Problem) -> Answer:
        """Let the reasoner decide; when it cannot, the encoder's answer has to do."""
        try:
            return self._router.conclude(snapshot, routed, self._reason(problem))
        except UnansweredError as error:
            return self._router.fall_back(routed, str(error), error.vlm_calls, error.usage)
        except ValueError as error:
            return self._router.fall_back(routed, str(error))

    def _think_of_name(
        self, snapshot: SceneSnapshot, row: int, naming: Naming, time_s: float
    ) -> Naming:
        """Let the reasoner look at the thing; when it cannot, the encoder's name has to do."""
        problem = replace(self._router.label_problem(snapshot, row), time_s=time_s)
        try:
            verdict = self._name(problem)
            return self._router.conclude_label(snapshot, row, verdict, len(naming.labels))
        except UnansweredError as error:
            return self._router.fall_back_label(naming, str(error), error.vlm_calls, error.usage)
        except ValueError as error:
            return self._router.fall_back_label(naming, str(error))

    def _tell(self, ask: Ask, answer: Answer, look: Look, watch: "Stopwatch") -> Reply:
        k = min(ask.k or DEFAULT_K, MAX_MATCHES)
        body = answer_json(answer, k, self._stamp(look, watch))
        best = body["instances"][:1]
        self._last_whole.append(body)
        self._last.append(
            {
                "query_id": body["query_id"],
                "question": answer.question[:MAX_SHOWN_CHARS],
                "status": answer.status,
                "route": answer.route,
                "best": [{name: match[name] for name in ("id", "label", "p")} for match in best],
                "took_ms": body["took_ms"],
            }
        )
        return reply(body, "answer", ask.fmt)

    def _listing(self, ask: Ask, look: Look, watch: "Stopwatch") -> Json:
        snapshot = look.snapshot
        known: dict[int, SceneInstance | Instance] = {}
        known |= {one.instance_id: one for one in snapshot.waiting}
        known |= {one.instance_id: one for one in snapshot.instances}
        if ask.instance_id is None:
            behind = [key for key in sorted(known) if key > ask.after]
            listed = behind[: min(ask.k or DEFAULT_K, MAX_LISTED)]
        elif ask.instance_id in known:
            listed = [ask.instance_id]
        else:
            raise self._no_such(ask.instance_id)
        body = listing_json(
            [known[key] for key in listed], snapshot.revision, self._stamp(look, watch)
        )
        return {**body, "count": len(known)}

    def _overview(self, look: Look) -> Json:
        return {
            **self._scene_json(look),
            "usage": {
                name: f"sceneq/query/{self._scene}/{name}{how}" for name, how in USAGE.items()
            },
            "labels": self._given(look, TOP_LABELS),
        }

    def _scene_json(self, look: Look) -> Json:
        snapshot = look.snapshot
        return {
            "scene": self._scene,
            "instances": snapshot.instance_count,
            "answerable": len(snapshot),
            "map": map_json(snapshot.revision, self._age_s(look)),
            "frame_seq": snapshot.revision.frame_seq,
        }

    def _given(self, look: Look, most: int) -> dict[str, int]:
        counts = Counter(instance.label.name for instance in look.snapshot.instances)
        return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0]))[:most])

    def _row(self, look: Look, instance_id: int) -> int:
        row = look.snapshot.find(instance_id)
        if row is None:
            raise self._no_such(instance_id)
        return row

    def _no_such(self, instance_id: int) -> QueryError:
        hint = f"list them: sceneq/query/{self._scene}/instances?k=100"
        return QueryError("not_found", f"there is no such instance: {instance_id}", hint)

    def _stamp(self, look: Look, watch: "Stopwatch") -> Stamp:
        return Stamp(
            scene=self._scene,
            query_id=uuid.uuid4().hex[:12],
            map_age_s=self._age_s(look),
            took_ms=watch.total_ms(),
            stage_ms=watch.stage_ms,
        )

    def _age_s(self, look: Look) -> float:
        return time.monotonic() - look.map_arrived_s


def _left_s(ask: Ask, watch: "Stopwatch") -> float:
    """Return how long a reasoner may take."""
    if ask.deadline_ms is None:
        return math.inf
    return max(0.0, (ask.deadline_ms - watch.total_ms()) / 1e3)


class Stopwatch:
    """Milliseconds per stage of one query."""

    def __init__(self) -> None:
        self._start_s = self._last_s = time.perf_counter()
        self.stage_ms: dict[str, float] = {}

    def lap(self, stage: str) -> None:
        """Book the time since the last lap on ``stage``."""
        now_s = time.perf_counter()
        self.stage_ms[stage] = (now_s - self._last_s) * 1e3
        self._last_s = now_s

    def total_ms(self) -> float:
        """Return the time since the start."""
        return (time.perf_counter() - self._start_s) * 1e3
