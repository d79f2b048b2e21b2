"""Who comes into a scene: what mapping answers, refuses and remembers."""

import json
from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.mapper import MapperParams
from sceneq_core.visits import is_same_visit, seq_in_scene, seq_of, visit_of
from sceneq_nodes._bus import QueryError
from sceneq_nodes._corrections import Corrections
from sceneq_nodes._place_message import place_from_message
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.mapping import Mapping, MappingParams
from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.place import PlaceSet
from sceneq_schemas.topics import PLACES, VISIT

from support.durable_map import DurableMap
from support.fake_bus import CONTEXT, FakeBus
from support.messages import EXAMPLES
from support.rigid import rigid

FIRST = {"robot": "r1", "seq": 0, "stamp_ns": 5, "fingerprint": 7}


class Desk:
    def __init__(self, folder=None) -> None:
        self.bus = FakeBus(replace(CONTEXT, store=folder))
        self.node = Mapping(MappingParams(mapper=MapperParams()), self.bus.context)
        self.node.open(self.bus)

    def say(self, payload=b"", **asked):
        payload = payload or (json.dumps(asked).encode() if asked else b"")
        return from_bytes(VISIT, self.bus.query(VISIT, payload=payload).payload)


def test_the_first_robot_founds_and_the_second_has_to_look():
    desk = Desk()
    assert desk.say(**FIRST)["T_world_odom"] == np.eye(4).tolist()
    second = desk.say(**FIRST | {"robot": "r2"})
    assert (second["visit"], second["T_world_odom"]) == (1, None)
    assert desk.say(**FIRST | {"robot": "r2"}) == second
    assert [visit["robot"] for visit in desk.say()["visits"]] == ["r1", "r2"]


def test_recordings_that_begin_alike_are_told_apart_by_their_images():
    desk = Desk()
    desk.say(**FIRST)
    assert desk.say(**FIRST)["visit"] == 0
    assert desk.say(**FIRST | {"fingerprint": 8})["visit"] == 1


def test_a_founder_that_sent_nothing_may_come_again():
    desk = Desk()
    desk.say(**FIRST)
    again = desk.say(**FIRST | {"stamp_ns": 9})
    assert (again["visit"], again["T_world_odom"]) == (1, np.eye(4).tolist())


def test_a_map_from_before_there_were_visits_is_the_first_one(tmp_path):
    map_ = DurableMap(tmp_path / "kept").show(0, 1)
    said = {"robot": "r1", "seq": 0, "stamp_ns": 0, "fingerprint": 1}
    told = from_bytes(VISIT, map_.bus.query(VISIT, payload=json.dumps(said).encode()).payload)
    assert (told["visit"], told["evidence"]) == (0, "the first one")
    said["stamp_ns"] = 77
    told = from_bytes(VISIT, map_.bus.query(VISIT, payload=json.dumps(said).encode()).payload)
    assert (told["visit"], told["T_world_odom"]) == (1, None)


def test_what_was_found_outlives_the_process(tmp_path):
    desk = Desk(tmp_path / "kept")
    desk.say(**FIRST)
    desk.say(**FIRST | {"robot": "r2"})
    found = rigid(3).tolist()
    desk.say(visit=1, T_world_odom=found, evidence="3 keyframes")
    told = desk.say()
    desk.node.close()
    again = Desk(tmp_path / "kept")
    assert again.say() == told
    assert again.say(**FIRST | {"robot": "r2"})["T_world_odom"] == found
    again.node.close()


@pytest.mark.parametrize(
    "asked",
    [
        b"no json",
        b"[" * 5000,
        b"[1]",
        b'{"robot": "R 1", "seq": 0, "stamp_ns": 0}',
        b'{"robot": "r1", "seq": -1, "stamp_ns": 0}',
        b'{"robot": "r1", "seq": "0", "stamp_ns": 0}',
        b'{"robot": "r1", "seq": true, "stamp_ns": 0}',
        b'{"robot": "r1", "seq": 0, "stamp_ns": 0, "start": "anywhere"}',
        b'{"robot": "r1", "seq": 0, "stamp_ns": 0, "origin": "../up"}',
        b'{"visit": 9, "T_world_odom": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}',
        b'{"visit": 0, "T_world_odom": [1, 2]}',
        b'{"visit": 0, "T_world_odom": [[2,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}',
        b'{"visit": 0, "T_world_odom": [[NaN,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}',
        b'{"visit": null, "T_world_odom": null}',
    ],
)
def test_what_no_source_says_is_refused(asked):
    desk = Desk()
    desk.say(**FIRST)
    before = desk.say()
    with pytest.raises(QueryError, match="bad_request"):
        desk.say(asked)
    assert desk.say() == before


def test_places_are_told_until_they_are_known(tmp_path):
    map_ = DurableMap(None).show(0, 5)
    reply = map_.bus.query(PLACES)
    told = from_bytes(PLACES, reply.payload)
    assert [place.seq for place in told.places] == [0, 5]
    assert place_from_message(told.places[0]).grey().shape == (90, 120)
    assert map_.bus.query(PLACES, parameters={"have": f"{told.epoch}:{told.seq}"}) is None


@pytest.mark.parametrize(
    "wrong",
    [
        {"jpeg": b"\xff\xd8 no"},
        {"T_world_camera": np.full((4, 4), np.nan)},
        {"K": np.zeros((3, 3))},
        {"depth_mm": np.zeros((0, 3), np.uint16)},
    ],
)
def test_places_that_are_none_are_refused(wrong):
    desk = DurableMap(None).show(0)
    (place,) = from_bytes(PLACES, desk.bus.query(PLACES).payload).places
    with pytest.raises(DecodeError, match="place 0"):
        place_from_message(replace(place, **wrong))
    example = next(one for one in EXAMPLES if isinstance(one, PlaceSet))
    with pytest.raises(DecodeError, match="place 7: a picture"):
        place_from_message(example.places[0])


def test_numbers_tell_the_visit():
    seq = seq_in_scene(3, 7)
    assert (visit_of(seq), seq_of(seq), visit_of(-1)) == (3, 7, 0)
    assert is_same_visit(seq, seq + 1)
    assert not is_same_visit(seq, 7)
    for visit, number in ((-1, 0), (0, -1), (0, 1 << 32), (1 << 20, 0)):
        with pytest.raises(ValueError, match="out of range"):
            seq_in_scene(visit, number)


def correction(visit, frame_seq, *keyframes):
    return PoseCorrection(
        *(1, 1, True, seq_in_scene(visit, frame_seq), 0),
        np.array([seq_in_scene(visit, seq) for seq in keyframes], np.int64),
        np.tile(np.eye(4), (len(keyframes), 1, 1)),
    )


def test_corrections_of_one_robot_leave_those_of_another_alone():
    corrections = Corrections()
    corrections.offer(correction(0, 5, 1, 2))
    corrections.offer(correction(1, 2, 0))
    assert corrections.due(seq_in_scene(1, 1)) == []
    assert len(corrections.due(seq_in_scene(1, 2))) == 1
    assert len(corrections.due(seq_in_scene(0, 9))) == 1
    assert sorted(corrections.parts()[1]) == [1, 2, seq_in_scene(1, 0)]
