"""One request to one scene, asked again while it is busy or its node comes back."""

import json
import time
from collections.abc import Mapping
from typing import Any

from sceneq_client.errors import BusyError, NoAnswerError, RefusedError, SceneError
from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._client import Client
from sceneq_schemas.topics import Topic

RETRY_MS = 200
"""How long to wait when nobody says how long."""
ABSENT_S = 5.0
"""How long to go on when nobody answers: a node that was killed is back after about two."""


def put(
    client: Client,
    topic: Topic,
    scene: str,
    request: Mapping[str, Any],
    timeout_s: float,
    absent_s: float = ABSENT_S,
) -> dict[str, Any]:
    """Return the JSON object that ``scene`` answers ``request`` with.

    Raises:
        NoAnswerError: nobody answers for the scene within ``absent_s``, or not in ``timeout_s``.
        BusyError: it was busy all the time.
        RefusedError: it answered with an error.
        SceneError: the answer is not one of ours.
    """
    payload, started = json.dumps(request).encode(), time.monotonic()
    while True:
        left_s = max(0.001, started + timeout_s - time.monotonic())
        replies, errors = client.get(topic.key(scene=scene), payload, "application/json", left_s)
        if replies:
            return json_object(replies[-1][1])
        if errors and errors[0].code != "busy":
            raise _refused(errors[0], scene, timeout_s)
        pause_s = (errors[0].retry_ms if errors and errors[0].retry_ms else RETRY_MS) / 1000
        limit_s = timeout_s if errors else min(timeout_s, absent_s)
        if time.monotonic() + pause_s >= started + limit_s:
            raise _given_up(errors, scene)
        time.sleep(pause_s)


def json_object(reply: Reply) -> dict[str, Any]:
    """Return the JSON object of a reply; ``SceneError`` when it is none."""
    try:
        value = json.loads(reply.payload)
    except (ValueError, RecursionError) as error:
        raise SceneError(f"the answer is not JSON: {error}") from error
    if not isinstance(value, dict):
        raise SceneError(f"the answer is not a JSON object: {value!r:.80}")
    return value


def _refused(error: QueryError, scene: str, timeout_s: float) -> SceneError:
    if error.code == "timeout":
        return NoAnswerError(f"scene '{scene}' did not answer within {timeout_s:g} s")
    return RefusedError(error.code, error.message, error.hint)


def _given_up(errors: list[QueryError], scene: str) -> SceneError:
    if errors:
        return BusyError(str(errors[0]))
    return NoAnswerError(f"nobody answers for scene '{scene}' (see: sceneq status)")
