"""Nodes on a bus of their own, with nobody else there, and a few things they know of."""

from collections import Counter
from collections.abc import Mapping
from typing import Any

import numpy as np

from sceneq_core.encoding.encoder import Encoder
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Context, Handler, Received, Reply
from sceneq_nodes._wire import to_bytes
from sceneq_nodes.routing import Routing
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.map import Instance, MapDelta
from sceneq_schemas.topics import FEATURE_DELTA, MAP_DELTA, VIEW_DELTA, Topic
from sceneq_schemas.view import View, ViewDelta, ViewSet

SCENE = Context(node="node", scene="room", robot="robot", sensor="camera")
HASH = {"kind": "hash"}
THINGS = ("table", "red mug", "blue mug", "chair", "lamp", "picture")
EPOCH = 5


class LoneBus:
    """The ``Bus`` of a node that nobody answers; what it publishes is encoded and forgotten."""

    def __init__(self) -> None:
        self.context = SCENE
        self.handlers: dict[str, Handler] = {}
        self.counters: Counter[str] = Counter()
        self.subscriptions: dict[str, int] = {}

    def publish(self, topic: Topic, message: Any, **ids: str) -> None:
        """Encode ``message``: what cannot be sent would end a node."""
        topic.key(**ids)
        to_bytes(topic, message)

    def subscribe(self, topic: Topic, *, depth: int, **ids: str) -> None:
        """Remember how many messages may wait; nobody sends any."""
        self.subscriptions[topic.name] = depth

    def serve(self, topic: Topic, handler: Handler, **ids: str) -> None:
        """Keep the handler to be called."""
        self.handlers[topic.key(**ids)] = handler

    def ask(
        self,
        topic: Topic,
        *,
        parameters: Mapping[str, str] | None = None,
        payload: bytes = b"",
        timeout_s: float = 2.0,
        **ids: str,
    ) -> list[Reply]:
        """Return no reply."""
        return []

    def alive(self) -> frozenset[str]:
        """Return nobody."""
        return frozenset()

    def count(self, name: str, by: int = 1) -> None:
        """Add to a counter."""
        self.counters[name] += by

    def report(self, **values: float | int | str) -> None:
        """Forget the values."""


def known_scene() -> tuple[Routing, LoneBus]:
    """Return a routing node that knows ``THINGS`` in a row, and its bus."""
    encoder: Encoder = build("encoder", HASH, ("encoder",))
    bus = LoneBus()
    node = Routing(Routing.Params(encoder=HASH, labels=THINGS), SCENE)
    node.open(bus)
    vectors = encoder.encode_texts(THINGS)
    for topic, message, ids in (
        (MAP_DELTA, map_of(len(THINGS)), {}),
        (VIEW_DELTA, views_of(len(THINGS)), {}),
        (FEATURE_DELTA, features_of(vectors, encoder.model_id), {"model": encoder.model_id}),
    ):
        ids = {"scene": SCENE.scene, **ids}
        node.step(Received(topic, topic.key(**ids), ids, message))
    return node, bus


def map_of(count: int) -> MapDelta:
    """Return a whole map of ``count`` things without surface."""
    none = np.zeros(0, np.int32)
    return MapDelta(
        epoch=EPOCH,
        seq=1,
        full=True,
        frame_seq=9,
        stamp_ns=1_000,
        voxel_size_m=0.02,
        up_world=np.array([0.0, 0.0, 1.0]),
        voxel_id=none,
        voxel_coord=np.zeros((0, 3), np.int32),
        points_world=np.zeros((0, 3), np.float32),
        rgb=np.zeros((0, 3), np.uint8),
        superpoint_id=none,
        removed_voxel_id=none,
        instances=tuple(_instance(number) for number in range(1, count + 1)),
    )


def views_of(count: int) -> ViewDelta:
    """Return one view of every thing."""
    box = np.array([1.0, 2.0, 9.0, 5.0], np.float32)
    view = View(9, 1_000, 40, box, (3, 8), b"\xff\x81\xff")
    sets = tuple(ViewSet(number, (view,)) for number in range(1, count + 1))
    return ViewDelta(1, 1, True, 9, 1_000, EPOCH, 1, sets)


def features_of(vectors: Any, model: str) -> FeatureDelta:
    """Return the rows of ``vectors`` as descriptors."""
    seen, feature = np.array([9], np.int64), np.ones(3, np.float32)
    rows = tuple(Descriptor(i, seen, row, feature) for i, row in enumerate(vectors, 1))
    return FeatureDelta(1, 1, True, 9, 1_000, model, rows, np.zeros(0, np.int32), EPOCH)


def _instance(number: int) -> Instance:
    centre_world = np.array([float(number), 0.0, 0.5])
    T_world_box = np.eye(4)
    T_world_box[:3, 3] = centre_world
    return Instance(
        instance_id=number,
        state="confirmed",
        merged_into=0,
        parent=0,
        superpoint_id=np.zeros(0, np.int32),
        voxel_count=40,
        centre_world=centre_world,
        aabb_world=np.stack([centre_world - 0.2, centre_world + 0.2]),
        T_world_box=T_world_box,
        box_size_m=np.full(3, 0.4),
        first_seen_ns=10,
        last_seen_ns=1_000,
    )
