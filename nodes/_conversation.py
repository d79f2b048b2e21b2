"""Questions in all their forms, from the words to the JSON of the answer."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache

from sceneq_core.routing.answer import FOUND, Answer
from sceneq_core.routing.forms import COUNT, EXISTS, FIND, WHAT, WHEN, WHERE, Form, read_form
from sceneq_core.routing.likelihood import Fit
from sceneq_core.routing.matches import MAX_MATCHES
from sceneq_core.routing.question import Question
from sceneq_core.routing.recall import with_past
from sceneq_core.routing.report import Report, gone_match
from sceneq_core.routing.router import Router
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_nodes._answer_json import Json
from sceneq_nodes._ask import DEFAULT_K, Ask
from sceneq_nodes._bus import QueryError
from sceneq_nodes._look import Look
from sceneq_nodes._report_json import report_json, reports_json
from sceneq_nodes._stopwatch import Stopwatch

REMEMBERED = 512
"""So many questions are remembered as read: people and robots ask the same things again."""

Fits = Mapping[str, Fit]
Answering = Callable[[SceneSnapshot, Question], tuple[Answer, Fits]]
"""How well every thing that a question speaks of fits the instances comes with the answer."""

_form = lru_cache(maxsize=REMEMBERED)(read_form)


class Conversation:
    """Reads the question of a request, has it answered, and reports in the form asked for."""

    def __init__(self, scene: str, router: Router) -> None:
        self._scene = scene
        self._router = router

    def hold(self, ask: Ask, look: Look, watch: Stopwatch, answering: Answering) -> Json:
        """Return the body of the answer; ``answering`` decides between instances.

        Whatever is counted or listed is judged one by one, without it.

        Raises:
            QueryError: ``bad_request``, there is no question in it.
        """
        form, questions = self._read(ask.text)
        watch.lap("text")
        snapshot = look.snapshot
        if form.kind == WHEN:
            snapshot = with_past(snapshot, self._router.labeller)
        if form.kind in (COUNT, WHAT):
            answering = self._at_once
        reports = [self._report(form, snapshot, one, answering) for one in questions]
        watch.lap("report")
        return self._body(reports, ask, look, watch)

    def _read(self, text: str) -> tuple[Form, tuple[Question, ...]]:
        try:
            form = _form(text)
            many = form.kind in (COUNT, EXISTS)
            return form, tuple(self._router.read(part, many=many) for part in form.parts)
        except ValueError as error:
            hint = "ask for a thing, such as red mug"
            raise QueryError("bad_request", str(error), hint) from error

    def _report(
        self, form: Form, snapshot: SceneSnapshot, question: Question, answering: Answering
    ) -> Report:
        answer, fits = answering(snapshot, question)
        report = self._router.reporter.report(form.kind, snapshot, question, answer, fits)
        if form.kind not in (FIND, WHERE, EXISTS) or answer.status == FOUND or not snapshot.past:
            return report
        once, _ = self._at_once(with_past(snapshot, self._router.labeller), question)
        return replace(report, gone=gone_match(once))

    def _at_once(self, snapshot: SceneSnapshot, question: Question) -> tuple[Answer, Fits]:
        routed = self._router.answer(snapshot, question)
        return routed.answer, routed.fits

    def _body(self, reports: list[Report], ask: Ask, look: Look, watch: Stopwatch) -> Json:
        k, stamp = min(ask.k or DEFAULT_K, MAX_MATCHES), look.stamp(self._scene, watch)
        if len(reports) > 1:
            return reports_json(reports, ask.text, k, stamp)
        (report,) = reports
        asked = replace(report.answer, question=ask.text)
        return report_json(replace(report, answer=asked), k, stamp)
