"""Everything a scene holds, gathered through its queryables."""

import json
from collections.abc import Mapping
from typing import Any, Protocol

from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._bus import Reply
from sceneq_nodes._convert import map_delta_from_message
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.topics import (
    FEATURE_SNAPSHOT,
    MAP_SNAPSHOT,
    QUERY_INSTANCES,
    QUERY_LABELS,
    QUERY_STATUS,
    Topic,
)
from sceneq_tools.errors import UserError
from sceneq_tools.scene_files import Descriptors, SceneFiles, no_descriptors

PAGE = 200


class Get(Protocol):
    """Asks one queryable of the scene; ``ids`` are the parts of its key besides the scene."""

    def __call__(self, topic: Topic, parameters: Mapping[str, Any], **ids: str) -> Reply | None:
        """Return the reply, ``None`` when nobody answers."""


def collect(get: Get, scene: str) -> SceneFiles:
    """Return the scene as it is now.

    Raises:
        UserError: mapping or routing does not answer.
        DecodeError: the map is not one of ours.
    """
    replica = MapReplica()
    message = from_bytes(MAP_SNAPSHOT, _need(get, MAP_SNAPSHOT, {}, scene).payload)
    replica.apply(map_delta_from_message(message))
    labels = json.loads(_need(get, QUERY_LABELS, {}, scene).payload)
    listed, described = _listed(get, scene), _described(get, scene)
    return SceneFiles(scene, labels["label_set"], replica, listed, described)


def _described(get: Get, scene: str) -> Descriptors:
    """Return the descriptors that questions are answered from; a graph may lack its encoder."""
    model = json.loads(_need(get, QUERY_STATUS, {}, scene).payload)["model"]
    reply = get(FEATURE_SNAPSHOT, {}, model=model)
    if reply is None:
        return no_descriptors(model)
    delta = from_bytes(FEATURE_SNAPSHOT, reply.payload)
    return Descriptors(
        model,
        rows={one.instance_id: one.descriptor for one in delta.descriptors},
        features={one.instance_id: one.feature for one in delta.descriptors},
    )


def _listed(get: Get, scene: str) -> tuple[Mapping[str, Any], ...]:
    listed: list[Mapping[str, Any]] = []
    while True:
        after = listed[-1]["id"] if listed else 0
        reply = _need(get, QUERY_INSTANCES, {"k": PAGE, "after": after}, scene)
        page = json.loads(reply.payload)["instances"]
        if not page:
            return tuple(listed)
        listed += page


def _need(get: Get, topic: Topic, parameters: Mapping[str, Any], scene: str) -> Reply:
    reply = get(topic, parameters)
    if reply is None:
        key = topic.key(scene=scene)
        raise UserError(f"nobody answers {key} (is {topic.writer} running? see: sceneq status)")
    return reply
