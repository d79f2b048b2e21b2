"""Standing questions: "tell me when a mug appears"."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

from sceneq_client.answer import Answer, Instance
from sceneq_client.errors import SceneError


@dataclass(frozen=True, slots=True)
class Sighting:
    """An instance that answers a standing question and did not before."""

    question: str
    instance: Instance
    answer: Answer


class StandingQuestion:
    """Asks again when the map has changed, at most every ``pause_s``, and tells what is new.

    ``changed`` may be called from any thread and as often as you like.
    """

    def __init__(
        self,
        question: str,
        ask: Callable[[str], Answer],
        tell: Callable[[Sighting], None],
        pause_s: float,
        min_p: float,
    ) -> None:
        self._question = question
        self._ask, self._tell = ask, tell
        self._pause_s, self._min_p = pause_s, min_p
        self._known: set[int] = set()
        self._changed, self._closed = threading.Event(), threading.Event()
        self._thread = threading.Thread(target=self._run, name="standing", daemon=True)
        self.unanswered = 0

    def start(self) -> None:
        """Ask for the first time, then whenever something changed."""
        self._changed.set()
        self._thread.start()

    def changed(self) -> None:
        """Say that the map is not what it was."""
        self._changed.set()

    def close(self) -> None:
        """Ask no more."""
        self._closed.set()
        self._changed.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._closed.is_set():
            self._changed.wait()
            self._changed.clear()
            if not self._closed.is_set():
                self._look()
            self._closed.wait(self._pause_s)

    def _look(self) -> None:
        try:
            answer = self._ask(self._question)
        except SceneError:
            self.unanswered += 1
            self._changed.set()  # its node comes back, or the question is asked for nothing
            return
        there = self._seen(answer)
        for instance in there:
            if instance.id not in self._known:
                self._tell(Sighting(self._question, instance, answer))
        self._known = {instance.id for instance in there}

    def _seen(self, answer: Answer) -> list[Instance]:
        if answer.best is None:
            return []
        return [one for one in answer.instances if one.p >= self._min_p]
