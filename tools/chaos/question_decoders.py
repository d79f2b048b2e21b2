"""Every queryable of the graph with whatever a client may send: selectors, texts, JSON, pictures.

What leaves a handler as anything but an answer or a ``QueryError`` would be an ``internal`` error.
"""

from collections.abc import Callable, Iterator, Mapping

import cv2
import msgpack

from sceneq_nodes._bus import Handler, QueryError, Request
from sceneq_nodes._queries import error_bytes, error_from_bytes, parse_parameters
from sceneq_nodes._recent_deltas import wanted_deltas
from sceneq_nodes._view_image import answer_image
from sceneq_nodes._wire import json_bytes
from sceneq_schemas import topics
from sceneq_schemas.topics import Topic
from sceneq_tools.chaos.decoder import Decoder
from sceneq_tools.chaos.mutation import BYTES, JSON, MSGPACK
from sceneq_tools.chaos.small_scene import SCENE, known_scene
from sceneq_tools.chaos.wire_decoders import small_frame

SELECTORS = (
    b"q=the red mug on the table;k=3;mode=fast;fmt=msgpack;deadline_ms=500",
    b"q=how many chairs are there?",
    b"q=what is between the lamp and the chair;mode=reason",
    b"q=the second mug from the left, and the picture above the table",
    b"q=where is aunt%20Mary%27s m\xc3\xbcg;labels=mug,cup;id=3",
    b"q=when did you last see the lamp",
    b"id=3;labels=mug,cup,bowl;k=2",
    b"k=100;after=2",
    b"id=2;name=my mug;by=anna;kind=name",
    b"view=9;x=3;y=4;name=my lamp",
    b"view=9;box=1,2,8,5;name=my lamp",
    b"name=my mug",
    b"epoch=5;after=1",
    b"seq=9;box=1,2,8,5",
    b"",
)
OBJECTS: tuple[Mapping[str, object], ...] = (
    {"q": "red mug", "k": 3, "mode": "fast", "fmt": "json", "labels": ["mug", "cup"]},
    {"id": 2, "name": "my mug", "by": "anna", "view": 9, "x": 3, "y": 4.5, "box": [1, 2, 8, 5]},
)
TOPICS = (
    *(topics.QUERY_INSTANCES, topics.QUERY_ASK, topics.QUERY_LABEL, topics.QUERY_STATUS),
    *(topics.QUERY_LABELS, topics.QUERY_LAST, topics.QUERY_NAMES),
    *(topics.TEACH_SET, topics.TEACH_FORGET),
)
PAYLOADS: Mapping[str, tuple[str, str]] = {
    "text": ("", BYTES),
    "JSON": ("application/json", JSON),
    "msgpack": ("application/msgpack", MSGPACK),
    "picture": ("", BYTES),
}


def question_decoders() -> Iterator[Decoder]:
    """Yield decoders of selectors and of every kind of payload, each asked of all queryables."""
    _, bus = known_scene()
    doors = [(topic, bus.handlers[topic.key(scene=SCENE.scene)]) for topic in TOPICS]
    refusals = (QueryError,)
    for topic, handler in doors:
        name = topic.pattern.partition("{scene}/")[2]
        yield Decoder(f"selector of {name}", _selecting(topic, handler), SELECTORS, BYTES, refusals)
    seeds = _payload_seeds()
    for kind, (encoding, form) in PAYLOADS.items():
        asked = doors[:1] if kind == "picture" else doors  # the others see nothing in a picture
        yield Decoder(f"payload {kind}", _paying(asked, encoding), seeds[kind], form, refusals)
    yield Decoder("selector of @journal", _of_journal, SELECTORS, BYTES, refusals)
    see = _of_image(seeds["picture"][0])
    yield Decoder("selector of @image", see, (b"seq=9", b"seq=9;box=1,2,8,5"), BYTES, refusals)
    errors = (error_bytes(QueryError("busy", "too many", "try again", 200)), b"Timeout")
    yield Decoder("error reply", error_from_bytes, errors, refusals=())


def request(topic: Topic, parameters: str, payload: bytes = b"", encoding: str = "") -> Request:
    """Return a request as the runtime makes it."""
    ids = {"scene": SCENE.scene}
    return Request(
        topic, topic.key(**ids), ids, False, parse_parameters(parameters), payload, encoding
    )


def _payload_seeds() -> Mapping[str, tuple[bytes, ...]]:
    rgb = small_frame().rgb
    pictures = tuple(cv2.imencode(end, rgb)[1].tobytes() for end in (".jpg", ".png"))
    return {
        "text": tuple(seed.partition(b"=")[2].partition(b";")[0] for seed in SELECTORS[:6]),
        "JSON": tuple(map(json_bytes, OBJECTS)),
        "msgpack": tuple(map(msgpack.packb, OBJECTS)),
        "picture": pictures,
    }


def _selecting(topic: Topic, handler: Handler) -> Callable[[bytes], object]:
    return lambda data: handler(request(topic, data.decode(errors="replace")))


def _paying(doors: list[tuple[Topic, Handler]], encoding: str) -> Callable[[bytes], object]:
    """Ask all queryables in turn; refused by all is refused."""

    def decode(data: bytes) -> None:
        refusals = []
        for topic, handler in doors:
            try:
                handler(request(topic, "", data, encoding))
            except QueryError as error:
                refusals.append(error)
        if len(refusals) == len(doors):
            raise refusals[0]

    return decode


def _of_journal(data: bytes) -> object:
    return wanted_deltas(request(topics.MAP_SNAPSHOT, data.decode(errors="replace")))


def _of_image(jpeg: bytes) -> Callable[[bytes], object]:
    asked = topics.MAP_SNAPSHOT
    return lambda data: answer_image(request(asked, data.decode(errors="replace")), lambda _: jpeg)
