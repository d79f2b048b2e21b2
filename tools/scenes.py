"""Which scenes answer at an endpoint, and how to put a question to one of them."""

import time
from dataclasses import dataclass
from typing import Any

from sceneq_client.asking import json_object, put
from sceneq_client.errors import RefusedError, SceneError
from sceneq_nodes._bus import Reply
from sceneq_nodes._client import Client
from sceneq_schemas.topics import ID, QUERY_STATUS, Topic
from sceneq_tools.errors import UserError

STATUS_TIMEOUT_S = 5.0
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
    try:
        told = put(client, topic, scene, request, timeout_s, absent_s=0.0)
    except SceneError as error:
        wrong_usage = isinstance(error, RefusedError) and error.code == "bad_request"
        raise UserError(str(error), 2 if wrong_usage else 1) from error
    return Asked(scene, told, 1000 * (time.monotonic() - started))


def body(reply: Reply) -> dict[str, Any]:
    """Return the JSON object of a reply; ``UserError`` when it is none."""
    try:
        return json_object(reply)
    except SceneError as error:
        raise UserError(str(error)) from error
