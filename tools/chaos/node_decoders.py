"""Whole nodes fed with damaged messages: whatever passes the schema must not end the process."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from sceneq_core.mapping.mapper import MapperParams
from sceneq_nodes._bus import Node, Received
from sceneq_nodes._images import frame_message
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.encoding import Encoding
from sceneq_nodes.mapping import Mapping
from sceneq_nodes.segmentation import Segmentation
from sceneq_nodes.views import Views
from sceneq_schemas import topics
from sceneq_schemas.codec import encode
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import Topic
from sceneq_tools.chaos.decoder import CountedError, Decoder
from sceneq_tools.chaos.examples import EXAMPLES
from sceneq_tools.chaos.mutation import MSGPACK
from sceneq_tools.chaos.small_scene import (
    HASH,
    SCENE,
    THINGS,
    LoneBus,
    features_of,
    known_scene,
    map_of,
    views_of,
)
from sceneq_tools.chaos.wire_decoders import small_frame

INPUTS_A_NODE = 500
"""A node is made anew after so many: what it has taken in must not hide what comes later."""
REFUSING = ("refused", "bad", "undecodable", "foreign", "repeated", "quarantined", "missing")
MODEL = "hash-v1"
Made = tuple[Node, LoneBus]


class FedNode:
    """Steps a node with the bytes of one topic; the node is renewed now and then."""

    def __init__(
        self,
        make: Callable[[], Made],
        topic: Topic,
        seqs: frozenset[int],
        others: Sequence[tuple[Topic, Any]] = (),
    ) -> None:
        """``seqs`` of the seeds: left alone by damage, they count up, as those of a writer do.

        ``others``: messages delivered before each input, under its number.
        """
        self._make = make
        self._topic = topic
        self._seqs = seqs
        self._others = others
        self._left = 0

    def __call__(self, data: bytes) -> None:
        """Deliver; raise ``DecodeError`` or ``CountedError`` where the input was refused."""
        message = from_bytes(self._topic, data)
        if not self._left:
            (self._node, self._bus), self._left = self._make(), INPUTS_A_NODE
        self._left -= 1
        number, before = INPUTS_A_NODE - self._left, self._refusals()
        for topic, other in self._others:
            self._deliver(topic, _numbered(other, number))
        untouched = getattr(message, "seq", None) in self._seqs
        self._deliver(self._topic, _numbered(message, number) if untouched else message)
        self._node.step(None)
        if grown := [name for name, n in self._refusals().items() if n > before.get(name, 0)]:
            raise CountedError(grown[0])

    def _deliver(self, topic: Topic, message: Any) -> None:
        known = {"scene": SCENE.scene, "robot": SCENE.robot, "sensor": SCENE.sensor}
        ids = {name: (known | {"model": MODEL})[name] for name in topic.id_names}
        self._node.step(Received(topic, topic.key(**ids), ids, message))

    def _refusals(self) -> dict[str, int]:
        counters = self._bus.counters
        return {name: n for name, n in counters.items() if any(part in name for part in REFUSING)}


def node_decoders() -> Iterator[Decoder]:
    """Yield every (node, topic it reads)."""
    frame = frame_message(small_frame(), "raw", "raw")
    height_width = (frame.rgb.shape[0], frame.rgb.shape[1])
    masks = Masks(frame.seq, frame.stamp_ns, np.ones(height_width, np.uint16))
    vectors = np.eye(len(THINGS), 256, dtype=np.float32)
    seeds: dict[Topic, tuple[Any, ...]] = {
        topics.FRAME: (frame, frame_message(small_frame(), "jpeg", "zstd")),
        topics.MASK: (masks,),
        topics.MAP_DELTA: (map_of(3), *_examples(topics.MAP_DELTA)),
        topics.VIEW_DELTA: (views_of(3), *_examples(topics.VIEW_DELTA)),
        topics.FEATURE_DELTA: (features_of(vectors, MODEL), *_examples(topics.FEATURE_DELTA)),
    }
    for name, make, topic, others in (
        ("segmentation", _segmentation, topics.FRAME, ()),
        ("mapping", _mapping, topics.FRAME, ((topics.MASK, masks),)),
        ("mapping", _mapping, topics.MASK, ((topics.FRAME, frame),)),
        ("mapping", _mapping, topics.POSE_CORRECTION, ()),
        ("mapping", _mapping, topics.PROPOSAL, ()),
        ("views", _views, topics.FRAME, ((topics.MAP_DELTA, map_of(3)),)),
        ("views", _views, topics.MAP_DELTA, ()),
        ("encoding", _encoding, topics.VIEW_DELTA, ()),
        ("routing", known_scene, topics.MAP_DELTA, ()),
        ("routing", known_scene, topics.VIEW_DELTA, ()),
        ("routing", known_scene, topics.FEATURE_DELTA, ()),
        ("routing", known_scene, topics.POSE, ()),
    ):
        valid = seeds.get(topic, _examples(topic))
        seqs = frozenset(getattr(one, "seq", 0) for one in valid)
        fed = FedNode(make, topic, seqs, others)
        data, refusals = tuple(map(encode, valid)), (ValueError, CountedError)
        yield Decoder(f"{name} node, {topic.name}", fed, data, MSGPACK, refusals)


def _numbered(message: Any, number: int) -> Any:
    names = {field.name for field in fields(message)} & {"seq", "frame_seq"}
    return replace(message, **dict.fromkeys(names, number))


def _examples(topic: Topic) -> tuple[Any, ...]:
    return tuple(one for one in EXAMPLES if type(one) is topic.message)


def _opened(node: Node) -> Made:
    bus = LoneBus()
    node.open(bus)
    return node, bus


def _segmentation() -> Made:
    return _opened(Segmentation(Segmentation.Params(), SCENE))


def _mapping() -> Made:
    return _opened(Mapping(Mapping.Params(mapper=MapperParams(voxel_size_m=0.2)), SCENE))


def _views() -> Made:
    return _opened(Views(Views.Params(), SCENE))


def _encoding() -> Made:
    return _opened(Encoding(Encoding.Params(encoder=HASH, nice=0), SCENE))
