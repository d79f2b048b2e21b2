"""Decoders of what comes over the bus or from a model server: messages, images, JSON."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from sceneq_core.frame import Frame
from sceneq_core.mapping.mapper import Mapper, MapperParams
from sceneq_core.mapping.proposals import Proposals
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.reasoning.reasoner import (
    Candidate,
    Constraint,
    LabelProblem,
    LabelVerdict,
    Problem,
    Usage,
    Verdict,
)
from sceneq_nodes import _reason_json as reasons
from sceneq_nodes._chat_wire import BadReplyError, completion_from_bytes
from sceneq_nodes._convert import map_delta_from_message, view_set_from_message
from sceneq_nodes._corrections import correction_of
from sceneq_nodes._images import array_from_image, frame_from_message, frame_message, image_data
from sceneq_nodes._wire import from_bytes
from sceneq_schemas import topics
from sceneq_schemas.codec import decode, encode
from sceneq_schemas.frame import ImageData
from sceneq_tools.chaos.decoder import Decoder
from sceneq_tools.chaos.examples import EXAMPLES, T_WORLD_CAMERA, K
from sceneq_tools.chaos.mutation import JSON, MSGPACK
from sceneq_tools.heartbeats import heartbeat
from sceneq_tools.status import from_health
from sceneq_tools.zenoh_codec import decode as as_text

SIZE = (24, 32)
HEALTH_KEY = topics.HEALTH.key(node="mapping")
HEALTH = (
    b'{"node":"mapping","kind":"mapping","pid":7,"state":"ready","uptime_s":1.5,"busy_s":0.0,'
    b'"rss_mb":90.1,"inbox":{"sceneq/mask/room/v1":1},"topics":{"mask":{"in":3,"age_ms":12}},'
    b'"counters":{"frames_integrated":3},"values":{"state":"playing","voxels":7}}'
)
COMPLETION = (
    b'{"choices":[{"message":{"content":"{\\"choice\\": 2}"},"finish_reason":"stop"}],'
    b'"usage":{"prompt_tokens":900,"completion_tokens":8}}'
)


def small_frame() -> Frame:
    """Return a frame of ``SIZE`` with noise in it."""
    noise = np.random.default_rng(0)
    rgb = noise.integers(0, 255, (*SIZE, 3), dtype=np.uint8)
    depth_m = noise.uniform(0.5, 4.0, SIZE).astype(np.float32)
    return Frame(7, 1_000, rgb, depth_m, K, T_WORLD_CAMERA)


def message_decoders() -> Iterator[Decoder]:
    """Yield a decoder for every topic that has a message, all the way to what a reader uses."""
    for topic in topics.TOPICS:
        if topic.message is None:
            continue
        seeds = tuple(encode(one) for one in EXAMPLES if type(one) is topic.message)
        if topic is topics.FRAME:
            codecs = (("raw", "raw"), ("jpeg", "zstd"))
            seeds += tuple(encode(frame_message(small_frame(), *pair)) for pair in codecs)
        used = _USES.get(topic.name, _as_it_is)
        yield Decoder(
            f"topic {topic.name}",
            lambda data, topic=topic, used=used: used(from_bytes(topic, data)),  # type: ignore[misc]
            seeds,
            MSGPACK,
            (ValueError,) if topic.name in _USES else Decoder("", str, ()).refusals,
        )


def other_decoders() -> Iterator[Decoder]:
    """Yield decoders of images alone, of JSON, and of what prints any message."""
    rgb = small_frame().rgb
    images = tuple(encode(image_data(rgb, codec)) for codec in ("raw", "jpeg", "zstd"))
    images += (encode(image_data(rgb[..., 0].astype(np.uint16) * 9, "zstd")),)
    yield Decoder("image", lambda d: array_from_image(decode(ImageData, d)), images, MSGPACK)
    yield Decoder("health", _hear, (HEALTH,), JSON)
    yield Decoder("any JSON topic", lambda d: from_bytes(topics.METRIC, d), (HEALTH,), JSON)
    yield Decoder("model reply", completion_from_bytes, (COMPLETION,), JSON, (BadReplyError,))
    yield Decoder("problem", reasons.any_problem_from_bytes, _problems(), JSON)
    yield Decoder("verdict", _verdicts, _verdict_seeds(), JSON)
    seeds = (*map(encode, EXAMPLES), HEALTH)
    yield Decoder("message as text", _print, seeds, refusals=())


def _as_it_is(message: Any) -> Any:
    return message


def _hear(data: bytes) -> None:
    heartbeat(HEALTH_KEY, data)
    from_health(HEALTH_KEY, data)


def _print(data: bytes) -> None:
    for key in (topics.MAP_DELTA.key(scene="room"), topics.QUERY_ASK.key(scene="room"), "other"):
        as_text(key, data)


def _verdicts(data: bytes) -> None:
    """The same bytes as either kind of verdict: refused by both is refused."""
    try:
        reasons.verdict_from_bytes(data)
    except ValueError:
        reasons.label_verdict_from_bytes(data)


def _journal(message: Any) -> None:
    for delta in message.deltas:
        _map(delta)


def _map(message: Any) -> None:
    replica, delta = MapReplica(), map_delta_from_message(message)
    replica.apply(delta)
    replica.apply(replace(delta, full=True))
    replica.cloud()


def _proposals(message: Any) -> None:
    columns = (message.points_world, message.mask_id, message.point_id, message.score)
    Proposals(*columns, message.label).of_points()


_USES: Mapping[str, Callable[[Any], object]] = {
    "frame": frame_from_message,
    "correction": lambda message: Mapper(MapperParams()).correct(correction_of(message)),
    "proposal": _proposals,
    "map_delta": _map,
    "map_snapshot": _map,
    "map_journal": _journal,
    "view_delta": lambda message: [view_set_from_message(v) for v in message.view_sets],
    "view_snapshot": lambda message: [view_set_from_message(v) for v in message.view_sets],
}


def _problems() -> tuple[bytes, ...]:
    candidate = Candidate(
        instance_id=3,
        role="target",
        words="mug",
        label="cup",
        p=0.5,
        cosine=0.25,
        centre_world=np.ones(3),
        T_world_box=T_WORLD_CAMERA,
        box_size_m=np.ones(3),
        views=((7, (1.0, 2.0, 3.0, 4.0)),),
    )
    problem = Problem(
        text="the mug on the table",
        target="mug",
        constraints=(Constraint("on", "table"),),
        candidates=(candidate,),
        up_world=np.array([0.0, 0.0, 1.0]),
        viewpoint_world=np.zeros(3),
    )
    views = ((7, (1.0, 2.0, 9.0, 8.0)),)
    label_problem = LabelProblem(3, (("mug", 0.5), ("cup", 0.25)), views, 2.5)
    return reasons.problem_bytes(problem), reasons.label_problem_bytes(label_problem)


def _verdict_seeds() -> tuple[bytes, ...]:
    label = LabelVerdict((("mug", 0.5),), "it is", 3, Usage(900, 8, 0.01))
    verdict = Verdict(((3, 0.5), (4, 0.25)), "it is", 1)
    return reasons.verdict_bytes(verdict), reasons.verdict_bytes(label)
