"""What a web request asks of the bus."""

import json
from collections.abc import Mapping
from typing import Any

from sceneq_nodes._bus import Bus, QueryError
from sceneq_nodes.web.problem import ProblemError, problem_of
from sceneq_schemas.topics import VIEW_IMAGE, Topic

Json = dict[str, Any]


class Desk:
    """Asks one scene; safe to use from several threads."""

    def __init__(self, bus: Bus, scene: str, timeout_s: float) -> None:
        self.scene = scene
        self._bus = bus
        self._timeout_s = timeout_s

    def ask(self, topic: Topic, said: Mapping[str, Any], payload: bytes = b"") -> Json:
        """Return the JSON object that ``topic`` answers with; what is ``None`` is not said.

        Raises:
            ProblemError: an error, or no answer.
        """
        data = self._get(topic, said, payload)
        try:
            body = json.loads(data)
        except (ValueError, RecursionError) as error:
            raise ProblemError(502, f"{topic.name}: not JSON") from error
        if not isinstance(body, dict):
            raise ProblemError(502, f"{topic.name}: not a JSON object")
        return body

    def picture(self, seq: int) -> bytes:
        """Return the JPEG of a keyframe; raise ``ProblemError`` when it is gone."""
        return self._get(VIEW_IMAGE, {"seq": seq}, b"")

    def _get(self, topic: Topic, said: Mapping[str, Any], payload: bytes) -> bytes:
        parameters = {name: str(value) for name, value in said.items() if value is not None}
        try:
            replies = self._bus.ask(
                topic,
                parameters=parameters,
                payload=payload,
                timeout_s=self._timeout_s,
                scene=self.scene,
            )
        except QueryError as error:
            self._bus.count("questions_refused")
            raise problem_of(error) from error
        if not replies:
            self._bus.count("questions_unanswered")
            raise ProblemError(503, f"nobody answers {topic.name}", "see GET /scene", 2)
        return replies[-1].payload
