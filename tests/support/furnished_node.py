"""The routing node in the furnished room, on the fake bus."""

import json
from dataclasses import replace
from typing import Any

import numpy as np

from sceneq_core.mapping.delta import MapDelta
from sceneq_nodes._convert import map_delta_message
from sceneq_nodes.routing import Routing
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.topics import FEATURE_DELTA, MAP_DELTA, QUERY_ASK, VIEW_DELTA
from sceneq_schemas.view import View, ViewDelta, ViewSet

from support.fake_bus import FakeBus
from support.furnished import ROOM, UP, WordEncoder, instance

EPOCH = 5
ENCODER = WordEncoder()
LABELS = ("floor", "wall", "couch", "pillow", "table", "cup", "counter", "picture", "chair", "lamp")


class RoutingHome:
    """``bus`` and ``node``; the kind ``words`` of encoder must be registered."""

    def __init__(self, **params: Any) -> None:
        self.bus = FakeBus()
        self.seq = 0
        encoder = {"kind": "words"}
        self.node = Routing(
            Routing.Params(encoder=encoder, labels=LABELS, **params), self.bus.context
        )
        self.node.open(self.bus)
        self.show(ROOM)

    def show(self, things: tuple) -> None:
        """Let the map, its views and descriptors be those of ``things``."""
        self.seq += 1
        for topic, message in (
            (MAP_DELTA, map_delta_of(things, EPOCH, self.seq)),
            (VIEW_DELTA, _view_delta(self.seq, things)),
        ):
            self.bus.deliver(self.node, topic, message)
        features = _feature_delta(self.seq, things)
        self.bus.deliver(self.node, FEATURE_DELTA, features, model=ENCODER.model_id)

    def ask(self, q: str, **parameters: str) -> dict[str, Any]:
        """Return the answer to a question."""
        return self.query(QUERY_ASK, q=q, **parameters)

    def query(self, topic: Any, **parameters: str) -> dict[str, Any]:
        """Return what a queryable says."""
        reply = self.bus.query(topic, parameters=parameters)
        assert reply is not None
        return json.loads(reply.payload)


def map_delta_of(things: tuple, epoch: int, seq: int = 1, **changes: Any) -> Any:
    """Return the message of a delta with ``things`` as instances 1, 2, ..., with ``changes``."""
    none = np.zeros(0, np.int32)
    delta = MapDelta(
        full=True,
        frame_seq=10 * seq,
        stamp_ns=1_000 * seq,
        voxel_size_m=0.02,
        up_world=UP,
        voxel_id=none,
        voxel_coord=np.zeros((0, 3), np.int32),
        points_world=np.zeros((0, 3), np.float32),
        rgb=np.zeros((0, 3), np.uint8),
        superpoint_id=none,
        removed_voxel_id=none,
        instances=tuple(instance(i + 1, thing) for i, thing in enumerate(things)),
    )
    return map_delta_message(replace(delta, **changes), epoch, seq)


def _view_delta(seq: int, things: tuple) -> ViewDelta:
    box = np.array([1.0, 2.0, 30.0, 40.0], np.float32)
    sets = tuple(
        ViewSet(i + 1, (View(10 * (i + 1), 5, 99, box, (0, 0), b""),)) for i in range(len(things))
    )
    return ViewDelta(1, seq, True, 10, 1_000, EPOCH, seq, sets)


def _feature_delta(seq: int, things: tuple) -> FeatureDelta:
    none = np.zeros(0, np.float32)
    vectors = ENCODER.encode_texts([thing.name for thing in things])
    rows = tuple(
        Descriptor(i + 1, np.array([10], np.int64), row, none) for i, row in enumerate(vectors)
    )
    removed = np.zeros(0, np.int32)
    return FeatureDelta(1, seq, True, 10, 1_000, ENCODER.model_id, rows, removed, EPOCH)
