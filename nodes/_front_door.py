"""The queryables of a scene: every handler answers from one immutable snapshot."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from sceneq_core.reasoning.reasoner import (
    LabelProblem,
    LabelVerdict,
    Problem,
    UnansweredError,
    Verdict,
)
from sceneq_core.routing.answer import REASONED, Answer, Naming, differ
from sceneq_core.routing.policy import Case, Decision, case_of
from sceneq_core.routing.question import Question
from sceneq_core.routing.router import Routed, Router
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_nodes._answer_json import Json
from sceneq_nodes._ask import Ask, left_s, read_ask, reply
from sceneq_nodes._bus import Reply, Request
from sceneq_nodes._chooser import Chooser, GateOnly
from sceneq_nodes._conversation import Answering, Conversation, Fits
from sceneq_nodes._last_answers import LastAnswers
from sceneq_nodes._look import Look
from sceneq_nodes._naming import NamingDesk, nobody, nobody_listens
from sceneq_nodes._picture_question import PictureQuestions, Seeing, blind
from sceneq_nodes._scene_pages import USAGE, ScenePages
from sceneq_nodes._stopwatch import Stopwatch


class FrontDoor:
    """Answers ``instances``, ``ask``, ``label``, ``status``, ``labels`` and ``last``."""

    def __init__(
        self,
        scene: str,
        router: Router,
        look: Callable[[], Look],
        reason: Callable[[Problem], Verdict],
        health: Callable[[], Json],
        name: Callable[[LabelProblem], LabelVerdict] = nobody,
        told: Callable[[Naming], None] = nobody_listens,
        policy: Chooser | None = None,
        seeing: Seeing = blind,
    ) -> None:
        self._scene = scene
        self._router = router
        self._look = look
        self._reason = reason
        self._policy = policy or GateOnly()
        self._pages = ScenePages(scene, router.labeller.label_set, look, health)
        self._naming = NamingDesk(scene, router.other_labels, look, name, told)
        self._conversation = Conversation(scene, router)
        self._pictures = PictureQuestions(scene, router, seeing)
        self._last = LastAnswers()

    def instances(self, request: Request) -> Reply | None:
        """Rank instances by a question, always at once; without one list them or explain."""
        watch, ask, look = Stopwatch(), read_ask(request), self._look()
        if ask.picture:
            return reply(self._pictures.answer(ask, look, watch), "answer", ask.fmt)
        if ask.text:
            return self._tell(ask, look, watch, partial(self._at_once, watch))
        if request.wildcard or (ask.k is None and ask.instance_id is None):
            return self._pages.overview(ask, look)
        return self._pages.listing(ask, look, watch)

    def ask(self, request: Request) -> Reply | None:
        """Answer a question; the reasoner decides what the encoder cannot."""
        watch, ask, look = Stopwatch(), read_ask(request), self._look()
        if not ask.text:
            return reply({"usage": USAGE["ask"]}, "usage", ask.fmt)
        if request.wildcard and ask.mode != "reason":
            return None
        return self._tell(ask, look, watch, partial(self._selectively, ask, watch))

    def label(self, request: Request) -> Reply | None:
        """Name one instance."""
        return self._naming.label(request)

    def status(self, request: Request) -> Reply | None:
        """How the scene and its nodes are."""
        return self._pages.status(request)

    def labels(self, request: Request) -> Reply | None:
        """What things may be called, and how often which name was given."""
        return self._pages.labels(request)

    def last(self, request: Request) -> Reply | None:
        """The last answers in short, or with ``k`` the last few as they were given."""
        ask = read_ask(request)
        if request.wildcard and ask.text:
            return None
        body = {"scene": self._scene, "answers": self._last.newest(ask.k)}
        return reply(body, "last", ask.fmt)

    def _at_once(
        self, watch: Stopwatch, snapshot: SceneSnapshot, question: Question
    ) -> tuple[Answer, Fits]:
        routed = self._router.answer(snapshot, question)
        watch.lap("search")
        return routed.answer, routed.fits

    def _selectively(
        self, ask: Ask, watch: Stopwatch, snapshot: SceneSnapshot, question: Question
    ) -> tuple[Answer, Fits]:
        """Let the reasoner decide what the encoder cannot."""
        routed = self._router.answer(snapshot, question)
        watch.lap("search")
        case, answer = case_of(routed, question), routed.answer
        decision = self._decide(ask, case)
        if decision.ask and routed.problem:
            problem = replace(routed.problem, time_s=left_s(ask, watch.total_ms()))
            answer = self._think(snapshot, routed, problem)
            self._learn(case, routed.answer, answer)
            watch.lap("reason")
        elif decision.why_not:
            answer = replace(answer, reason=f"{answer.reason}; {decision.why_not}")
        return answer, routed.fits

    def _decide(self, ask: Ask, case: Case) -> Decision:
        """What the question itself says goes before the policy."""
        if ask.mode:
            return Decision(ask=ask.mode == "reason")
        return self._policy.decide(case)

    def _learn(self, case: Case, fast: Answer, answer: Answer) -> None:
        if answer.route == REASONED and not answer.cached:
            self._policy.told(case, changed=differ(fast, answer))

    def _think(self, snapshot: SceneSnapshot, routed: Routed, problem: Problem) -> Answer:
        """Let the reasoner decide; when it cannot, the encoder's answer has to do."""
        try:
            return self._router.conclude(snapshot, routed, self._reason(problem))
        except UnansweredError as error:
            return self._router.fall_back(routed, str(error), error.vlm_calls, error.usage)
        except ValueError as error:
            return self._router.fall_back(routed, str(error))

    def _tell(self, ask: Ask, look: Look, watch: Stopwatch, answering: Answering) -> Reply:
        body = self._conversation.hold(ask, look, watch, answering)
        self._last.keep(body)
        return reply(body, "answer", ask.fmt)
