"""10,000 damaged messages: each decodes or is refused; none crashes or allocates without bound."""

import struct
import tracemalloc
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import msgpack
import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_core.reasoning.reasoner import (
    Candidate,
    Constraint,
    LabelProblem,
    LabelVerdict,
    Problem,
    Usage,
    Verdict,
)
from sceneq_nodes._ask import read_ask
from sceneq_nodes._bus import QueryError, Request
from sceneq_nodes._convert import map_delta_from_message, view_set_from_message
from sceneq_nodes._images import array_from_image, frame_from_message, frame_message, image_data
from sceneq_nodes._queries import error_bytes, error_from_bytes, parse_parameters
from sceneq_nodes._reason_json import (
    any_problem_from_bytes,
    label_problem_bytes,
    label_verdict_from_bytes,
    problem_bytes,
    problem_from_bytes,
    verdict_bytes,
    verdict_from_bytes,
)
from sceneq_nodes._wire import from_bytes
from sceneq_schemas.codec import decode, encode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import Frame as FrameMessage
from sceneq_schemas.frame import ImageData
from sceneq_schemas.map import MapDelta
from sceneq_schemas.topics import HEALTH, QUERY_ASK, TOPICS
from sceneq_schemas.view import ViewDelta

from support.messages import EXAMPLES, T_WORLD_CAMERA, K

MUTANTS = 1_000
"""Per decoder; there are eleven."""
MEMORY_PER_BYTE = 16
MEMORY_BYTES = 2 * 1024 * 1024
HUGE = b"\xff\xff\xff\xff"
HEADERS = (
    *(code + HUGE for code in (b"\xc6", b"\xc9", b"\xdb", b"\xdd", b"\xdf")),
    *(code + b"\xff\xff" for code in (b"\xc5", b"\xc8", b"\xda", b"\xdc", b"\xde")),
    b"\xc1",
    b"\x91" * 600,
    b"\x81\xa1b" * 400,
    b"\xcb\x7f\xf8\x00\x00\x00\x00\x00\x00",
    b"\xd3" + struct.pack(">q", -(2**63)),
    b"\x28\xb5\x2f\xfd",
    b"\xff\xc0\x00\x11\x08\xff\xff\xff\xff\x03",
)
TEXTS = (b"[" * 2_000, b"9" * 400, b"-1e999", b"NaN", b"null", b'{"a":', b"\\ud800", b"\xff", b"]")
Decoder = Callable[[bytes], object]


def small_frame() -> Frame:
    rng = np.random.default_rng(0)
    rgb = rng.integers(0, 255, (24, 32, 3), dtype=np.uint8)
    depth_m = rng.uniform(0.5, 4.0, (24, 32)).astype(np.float32)
    return Frame(7, 1_000, rgb, depth_m, K, T_WORLD_CAMERA)


def decode_frame(data: bytes) -> object:
    return frame_from_message(decode(FrameMessage, data))


def decode_map(data: bytes) -> object:
    return map_delta_from_message(decode(MapDelta, data))


def decode_views(data: bytes) -> object:
    return [view_set_from_message(v) for v in decode(ViewDelta, data).view_sets]


def decode_image(data: bytes) -> object:
    return array_from_image(decode(ImageData, data))


def decode_any_topic(data: bytes) -> None:
    """Give the bytes to the decoder of every other message."""
    for topic in TOPICS:
        if topic.message is not None:
            with_limit = replace(topic, max_bytes=4096)
            try:
                from_bytes(with_limit, data)
            except DecodeError:
                continue


def decode_ask(data: bytes) -> None:
    """A question as text, JSON and msgpack; what it refuses, it refuses as ``bad_request``."""
    for encoding in ("", "application/json", "application/msgpack"):
        ids = {"scene": "room"}
        key = QUERY_ASK.key(**ids)
        try:
            read_ask(Request(QUERY_ASK, key, ids, False, {}, data, encoding))
        except QueryError as error:
            if error.code != "bad_request":
                raise


def decode_query(data: bytes) -> None:
    """These two take anything: what is no error of ours is an unknown one."""
    assert isinstance(error_from_bytes(data), QueryError)
    assert isinstance(parse_parameters(data.decode(errors="replace")), dict)


FRAME = small_frame()
PROBLEM = Problem(
    text="the mug on the table",
    target="mug",
    constraints=(Constraint("on", "table"),),
    candidates=(
        Candidate(
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
        ),
    ),
    up_world=np.array([0.0, 0.0, 1.0]),
    viewpoint_world=np.zeros(3),
)
LABEL_PROBLEM = LabelProblem(3, (("mug", 0.5), ("cup", 0.25)), ((7, (1.0, 2.0, 9.0, 8.0)),), 2.5)
TAKE_ANYTHING = ("every topic", "ask", "query")
DECODERS: dict[str, tuple[Decoder, list[bytes]]] = {
    "frame raw": (decode_frame, [encode(frame_message(FRAME, "raw", "raw"))]),
    "frame packed": (decode_frame, [encode(frame_message(FRAME, "jpeg", "zstd"))]),
    "image": (
        decode_image,
        [encode(image_data(FRAME.rgb, codec)) for codec in ("raw", "jpeg", "zstd")],
    ),
    "map": (decode_map, [encode(m) for m in EXAMPLES if isinstance(m, MapDelta)]),
    "views": (decode_views, [encode(m) for m in EXAMPLES if isinstance(m, ViewDelta)]),
    "every topic": (decode_any_topic, [encode(m) for m in EXAMPLES]),
    "json": (lambda data: from_bytes(HEALTH, data), [b'{"node":"a","x":[1,2.5,null,"\xc3\xbc"]}']),
    "problem": (problem_from_bytes, [problem_bytes(PROBLEM)]),
    "label problem": (any_problem_from_bytes, [label_problem_bytes(LABEL_PROBLEM)]),
    "label verdict": (
        label_verdict_from_bytes,
        [verdict_bytes(LabelVerdict((("mug", 0.5),), "it is", 3, Usage(900, 8, 0.01)))],
    ),
    "verdict": (verdict_from_bytes, [verdict_bytes(Verdict(((3, 0.5), (4, 0.25)), "it is", 1))]),
    "ask": (decode_ask, [b'{"q":"red mug","k":3}', msgpack.packb({"q": "mug", "k": 3})]),
    "query": (decode_query, [error_bytes(QueryError("a", "b", "c", 5)), b"q=red%20mug;k=5;%C3%BC"]),
}


def mutate(data: bytes, rng: np.random.Generator) -> bytes:
    """Return ``data`` with one to three kinds of damage."""
    damaged = bytearray(data)
    for _ in range(rng.integers(1, 4)):
        at = int(rng.integers(0, len(damaged) + 1))
        texts = HEADERS if data[:1] != b"{" else TEXTS
        header = texts[rng.integers(0, len(texts))]
        match rng.integers(0, 6):
            case 0 if at < len(damaged):
                damaged[at] ^= 1 << int(rng.integers(0, 8))
            case 1:
                del damaged[at:]
            case 2:
                damaged[at:at] = header
            case 3:
                damaged[at : at + len(header)] = header
            case 4:
                damaged[at:at] = damaged[int(rng.integers(0, at + 1)) : at]
            case _:
                damaged[at : at + 8] = rng.bytes(8)
    return bytes(damaged)


def refused(decoder: Decoder, data: bytes) -> bool:
    """Return whether ``decoder`` refused; anything but ``DecodeError`` is a crash and comes out."""
    try:
        decoder(data)
    except DecodeError:
        return True
    return False


@pytest.fixture
def traced() -> Any:
    tracemalloc.start()
    yield
    tracemalloc.stop()


@pytest.mark.parametrize("name", DECODERS)
def test_damaged_messages_are_refused_in_bounded_memory(name: str, traced: None) -> None:
    decoder, originals = DECODERS[name]
    rng = np.random.default_rng(len(name))
    refusals = 0
    for i in range(MUTANTS):
        data = mutate(originals[i % len(originals)], rng)
        tracemalloc.reset_peak()
        before, _ = tracemalloc.get_traced_memory()
        refusals += refused(decoder, data)
        _, peak = tracemalloc.get_traced_memory()
        assert peak - before <= MEMORY_BYTES + MEMORY_PER_BYTE * len(data), data.hex()
    assert refusals > MUTANTS // 4 or name in TAKE_ANYTHING


@pytest.mark.parametrize("name", DECODERS)
def test_the_undamaged_ones_decode(name: str) -> None:
    decoder, originals = DECODERS[name]
    assert not any(refused(decoder, data) for data in originals)


def test_numbers_beyond_a_float_are_refused_or_scaled() -> None:
    verdict = verdict_bytes(Verdict(((3, 0.5),), "", 0)).replace(b"0.5", b"9" * 400)
    assert refused(verdict_from_bytes, verdict)
    up = problem_bytes(PROBLEM).replace(b"[0.0,0.0,1.0]", b"[3e300,0,4e300]", 1)
    assert refused(problem_from_bytes, up) is False
    assert problem_from_bytes(up).up_world.tolist() == pytest.approx([0.6, 0.0, 0.8])


@pytest.mark.parametrize("header", [b"\xdd", b"\xdf"])
def test_nested_headers_cannot_multiply(header: bytes, traced: None) -> None:
    """Lists of lists, each announcing all the limit allows, reserve memory at every level."""
    key = b"\xa1b" if header == b"\xdf" else b""
    for length in (1_000, 16_384, 65_536):
        bomb = (header + struct.pack(">I", min(length // 8, 16_384)) + key) * (length // 5)
        tracemalloc.reset_peak()
        assert all(refused(partial(decode, type(m)), bomb[:length]) for m in EXAMPLES)
        _, peak = tracemalloc.get_traced_memory()
        assert peak < 160 * 1024 * 1024
