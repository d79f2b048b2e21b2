import numpy as np

from sceneq_tools.room.room import FLOOR_ID
from sceneq_tools.room.truth.sightings import Sightings
from sceneq_tools.room.truth.truth import Period, Truth, questions_document

from support.boxed_room import boxed_room
from support.room_edit import edited


def truth(*periods: Period) -> Truth:
    periods = periods or (Period(0, boxed_room()),)
    pixels = np.zeros((20, 15), np.int64)
    pixels[:, 1] = 1000
    pixels[2:6, 8] = 800
    pixels[12:19, 8] = 700
    pixels[3, 9] = 30
    return Truth(periods, Sightings(pixels, 10.0, 640 * 480))


def changed() -> Truth:
    room = boxed_room()
    return truth(Period(0, room), Period(10, edited(room), ("the mug was moved",)))


def record(document: dict, thing_id: int) -> dict:
    return next(row for row in document["instances"] if row["id"] == thing_id)


def test_one_record_a_thing_with_its_box_and_what_was_seen_of_it() -> None:
    row = record(truth().instances(lambda _: "by nobody, CC0"), 8)
    assert row["name"] == "mug_01"
    assert (row["frames"], row["pixels"], row["most_pixels"]) == (11, 8100, 800)
    assert row["history"] == [
        {"from_frame": 0, "box": [[4.455, 1.055, 0.74], [4.545, 1.145, 0.84]]}
    ]
    assert (row["support"], row["relation"], row["attribution"]) == (
        "desk_01",
        "on",
        "by nobody, CC0",
    )
    assert row["attributes"]["colour"] == "red"
    assert row["oriented_box"]["size"] == [0.09, 0.09, 0.1]


def test_names_are_unique_and_count_their_kind() -> None:
    names = truth().names()
    assert len(set(names.values())) == len(names)
    assert [names[i] for i in (2, 3, 4, 5)] == ["wall_01", "wall_02", "wall_03", "wall_04"]


def test_stuff_has_a_box_and_nothing_to_ask_for() -> None:
    row = record(truth().instances(lambda _: ""), FLOOR_ID)
    assert row["stuff"]
    assert "attributes" not in row


def test_a_history_tells_every_move() -> None:
    document = changed().instances(lambda _: "")
    mug = record(document, 8)["history"]
    assert [stay["from_frame"] for stay in mug] == [0, 10]
    assert mug[1]["box"] == [[2.455, 1.955, 0.42], [2.545, 2.045, 0.52]]
    assert record(document, 9)["history"][1] == {"from_frame": 10, "box": None}
    assert record(document, 14)["history"][0] == {"from_frame": 0, "box": None}
    assert len(record(document, 7)["history"]) == 1


def test_segments_tell_the_edits() -> None:
    first, second = changed().instances(lambda _: "")["segments"]
    assert (first["first"], first["last"], first["edits"]) == (0, 9, {})
    assert (second["first"], second["last"]) == (10, 19)
    assert second["edits"] == {
        "mug_01": [-2.0, 0.9, -0.32, 90.0],
        "book_01": None,
        "vase_01": "new",
    }
    assert second["changes"] == ["the mug was moved"]


def test_relations_belong_to_a_segment() -> None:
    rows = changed().instances(lambda _: "")["relations"]
    on = [
        (r["object"], r["segment"]) for r in rows if (r["type"], r["subject"]) == ("on", "mug_01")
    ]
    assert on == [("desk_01", "period 1"), ("coffee_table_01", "period 2")]


def test_only_what_was_seen_where_it_is_now_is_known_well() -> None:
    assert truth().survey().well == {8}
    assert changed().survey().well == frozenset()
    assert [t.id for t in changed().survey().gone] == [9]


def test_questions_name_their_answers() -> None:
    from sceneq_tools.room.truth.questions import Question

    asked = (
        Question("bathtub", "absent", (), "name"),
        Question("the mug on the desk", "spatial", (8,), "on", 0, 7),
    )
    document = questions_document("office_0", asked, truth().names(), 20)
    assert document["after_frame"] == 19
    assert document["queries"][0] == {
        "text": "the mug on the desk",
        "bucket": "spatial",
        "targets": ["mug_01"],
        "kind": "on",
        "distractors": 0,
        "anchor": "desk_01",
    }
    assert document["queries"][1]["targets"] == []
