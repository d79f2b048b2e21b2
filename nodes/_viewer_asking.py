"""What the viewer asks the front door: the names of instances and the last answers."""

import json
import logging
from collections.abc import Mapping, Sequence
from typing import Any

from sceneq_nodes._bus import Bus, QueryError
from sceneq_nodes._caption import caption
from sceneq_schemas.topics import QUERY_INSTANCES, QUERY_LAST, VIEW_IMAGE, Topic

log = logging.getLogger(__name__)

PAGE = 200
TIMEOUT_S = 1.0

Json = Mapping[str, Any]


class Asking:
    """Asks without insisting: where nobody answers, what was known stays."""

    def __init__(self, bus: Bus, scene: str) -> None:
        self._bus = bus
        self._scene = scene

    def captions(self) -> dict[int, str] | None:
        """Return what every instance is called, ``None`` when that cannot be had now."""
        found: dict[int, str] = {}
        after = 0
        while True:
            body = self._ask(QUERY_INSTANCES, k=PAGE, after=after)
            page = body.get("instances") if body is not None else None
            if not isinstance(page, list):
                return None
            found |= {record["id"]: caption(record) for record in page}
            if len(page) < PAGE:
                return found
            after = page[-1]["id"]

    def earlier(self) -> Sequence[Json]:
        """Return the last answers in short, the newest first."""
        body = self._ask(QUERY_LAST)
        return [] if body is None else list(body["answers"])

    def newest(self) -> Json | None:
        """Return the newest answer as it was given."""
        body = self._ask(QUERY_LAST, k=1)
        return body["answers"][0] if body is not None and body["answers"] else None

    def picture(self, seq: int) -> bytes | None:
        """Return the JPEG of a keyframe, ``None`` when it is gone."""
        return self._get(VIEW_IMAGE, seq=seq)

    def _ask(self, topic: Topic, **parameters: int) -> Json | None:
        data = self._get(topic, **parameters)
        if data is None:
            return None
        try:
            body = json.loads(data)
        except (ValueError, RecursionError):
            body = None
        if isinstance(body, dict):
            return body
        self._bus.count("answers_bad")
        log.warning("%s: answered with %d bytes that are no JSON object", topic.name, len(data))
        return None

    def _get(self, topic: Topic, **parameters: int) -> bytes | None:
        said = {name: str(value) for name, value in parameters.items()}
        try:
            replies = self._bus.ask(topic, parameters=said, timeout_s=TIMEOUT_S, scene=self._scene)
        except QueryError as error:
            self._bus.count(f"{topic.name}_refused")
            log.info("%s: %s", topic.name, error)
            return None
        return replies[0].payload if replies else None
