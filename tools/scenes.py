"""Which scenes answer at an endpoint, and how to put a question to one of them."""

import json
import time
from dataclasses import dataclass
from typing import Any

from sceneq_nodes._bus import QueryError, Reply
from sceneq_nodes._client import Client
from sceneq_schemas.topics import ID, QUERY_STATUS, Topic
from sceneq_tools.errors import UserError

STATUS_TIMEOUT_S = 5.0
TRIES = 5
RETRY_MS = 200
START_HINT = "start one: sceneq up --source FOLDER"


@dataclass(frozen=True, slots=True)
class Asked:
    """An answer and the time from question to answer as the client saw it."""

    scene: str
    body: dict[str, Any]
    round_trip_ms: float


def connect(endpoint: str) -> Client:
    """Return a client, to be used in a ``with`` block; ``UserError`` when no router is there."""
    try:
        return Client(endpoint)
    except ValueError as error:
        raise UserError(str(error), 2) from error
    except ConnectionError as error:
        hint = f"{START_HINT}, or say where with --connect tcp/HOST:PORT"
        raise UserError(f"no router at {endpoint} ({hint})") from error


def scene_status(client: Client) -> dict[str, dict[str, Any]]:
    """Return scene -> what it says about itself, of every scene that answers."""
    replies, _ = client.get(QUERY_STATUS.selector(), timeout_s=STATUS_TIMEOUT_S)
    found = ((QUERY_STATUS.ids(key), reply) for key, reply in replies)
    return {ids["scene"]: body(reply) for ids, reply in sorted_by_scene(found) if ids}


def sorted_by_scene(found: Any) -> list[tuple[dict[str, str], Reply]]:
    """Return (ids, reply) pairs in the order of their scenes."""
    return sorted(((i, r) for i, r in found if i), key=lambda pair: pair[0]["scene"])


def need_scene(client: Client, scene: str | None) -> str:
    """Return ``scene`` if given, else the only one that answers.

    Raises:
        UserError: nobody answers, several do, or the name is no id.
    """
    if scene is not None:
        if not ID.fullmatch(scene):
            raise UserError(f"--scene {scene!r}: must match {ID.pattern}", 2)
        return scene
    scenes = list(scene_status(client))
    if len(scenes) > 1:
        raise UserError(f"several scenes answer: {', '.join(scenes)} (say which with --scene)", 2)
    if not scenes:
        raise UserError(f"no scene answers ({START_HINT})")
    return scenes[0]


def ask(
    client: Client, topic: Topic, scene: str, request: dict[str, Any], timeout_s: float
) -> Asked:
    """Send a request to one scene; waits and asks again while it is busy.

    Raises:
        UserError: nobody answers, no answer in time, or an error reply.
    """
    started = time.monotonic()
    payload = json.dumps(request).encode()
    error = QueryError("none", "")
    for _ in range(TRIES):
        replies, errors = client.get(topic.key(scene=scene), payload, "application/json", timeout_s)
        if replies:
            took_ms = 1000 * (time.monotonic() - started)
            return Asked(scene, body(replies[-1][1]), took_ms)
        if not errors:
            raise UserError(f"nobody answers for scene '{scene}' (see: sceneq status)")
        error = errors[0]
        if error.code != "busy":
            break
        time.sleep((error.retry_ms or RETRY_MS) / 1000)
    raise _as_user_error(error, scene, timeout_s)


def body(reply: Reply) -> dict[str, Any]:
    """Return the JSON object of a reply; ``UserError`` when it is none."""
    try:
        value = json.loads(reply.payload)
    except (ValueError, RecursionError) as error:
        raise UserError(f"the answer is not JSON: {error}") from error
    if not isinstance(value, dict):
        raise UserError(f"the answer is not a JSON object: {value!r:.80}")
    return value


def _as_user_error(error: QueryError, scene: str, timeout_s: float) -> UserError:
    if error.code == "timeout":
        return UserError(f"scene '{scene}' did not answer within {timeout_s:g} s")
    hint = f" ({error.hint})" if error.hint else ""
    return UserError(
        f"{error.code}: {error.message}{hint}", 2 if error.code == "bad_request" else 1
    )
