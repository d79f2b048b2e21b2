"""The plug-in of the third-party `zenoh` command shows every message as text."""

import json
from importlib.metadata import entry_points

import msgpack
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sceneq_schemas.codec import encode as encode_message
from sceneq_schemas.frame import Pose
from sceneq_schemas.topics import POSE
from sceneq_tools.zenoh_codec import decode, encode

ANSWER = {
    "status": "ambiguous",
    "question": "mug",
    "instances": [
        {"id": 3, "label": "cup", "p": 0.5, "cosine": 0.4, "centre": [1, 2, 3], "views": []},
        {"id": 14, "label": "bowl", "p": 0.25, "views": [{"seq": 8}, {"seq": 9}]},
    ],
    "confidence": {"p_max": 0.5},
    "route": "fallback",
    "reason": "no reasoner answered",
}
ANSWER_TEXT = """\
ambiguous: 'mug' by the fallback route (no reasoner answered)
  id  label  p     cosine  centre m        size m  seen in
  3   cup    0.5   0.4     1.00 2.00 3.00  -       -
  14  bowl   0.25  -       -               -       8 9
confidence: p_max 0.5"""


def test_the_command_finds_the_codec() -> None:
    for group, function in (("decoders", decode), ("encoders", encode)):
        (point,) = entry_points(group=f"zenoh_cli.codecs.{group}", name="sceneq")
        assert point.load() is function


def test_an_answer_is_a_table_in_either_format() -> None:
    key = "sceneq/query/room/instances"
    assert decode(key, json.dumps(ANSWER).encode()) == ANSWER_TEXT
    assert decode(key, msgpack.packb(ANSWER)) == ANSWER_TEXT


def test_other_json_is_named_values() -> None:
    body = {"node": "a", "inbox": {"x": 1}, "alive": ["a", "b"], "topics": [{"n": 1, "m": "t"}]}
    assert decode("sceneq/health/a", json.dumps(body).encode()) == (
        "sceneq/health/a\n  node: a\n  inbox:\n    x: 1\n"
        '  alive: ["a", "b"]\n  topics: 1\n    - n 1, m t'
    )


def test_a_typed_message_shows_its_fields() -> None:
    pose = Pose(7, 123, np.eye(4), "given", True)
    assert decode(POSE.key(robot="r"), encode_message(pose)) == (
        "sceneq/pose/r/v1\n  seq: 7\n  stamp_ns: 123\n"
        "  T_world_camera: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], "
        "[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]\n  source: given\n  keyframe: true"
    )


def test_what_is_no_message_is_described() -> None:
    assert decode(POSE.key(robot="r"), b"\xff\xff").startswith(
        "2 bytes that are no message of sceneq/pose/r/v1: "
    )


@given(st.binary(max_size=64), st.sampled_from(["a/b", POSE.key(robot="r"), "sceneq/query/a/ask"]))
def test_no_bytes_break_it(data: bytes, key: str) -> None:
    assert isinstance(decode(key, data), str)


def test_a_question_travels_as_it_is_and_json_compact() -> None:
    assert encode("k", "red mug; left") == b"red mug; left"
    assert encode("k", '{ "q": "Stühle" }') == '{"q":"Stühle"}'.encode()
