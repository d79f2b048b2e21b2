"""Names stick, follow merges and new maps, are inherited and taken back."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.mapping.delta import REMOVED
from sceneq_core.reasoning.reasoner import LabelVerdict
from sceneq_core.routing.label_board import InstanceLabel, LabelBoard
from sceneq_core.routing.labels import ENCODER, INHERITED, TAUGHT
from sceneq_core.routing.names import NO_NAMES
from sceneq_core.teaching.evidence import Judgement
from sceneq_core.teaching.reading import MAX_HEIRS
from sceneq_core.teaching.taught import when
from sceneq_core.teaching.wording import CATEGORY, INDIVIDUAL

from support.furnished import ROOM, Thing, instance, router
from support.taught import STAMP_NS, TaughtRoom

MUG = "aunt Mary's mug"
ROUTER = router()
RED_CUP, BLUE_CUP, CHAIRS, BOX = 6, 7, (11, 12, 13), 14


@pytest.fixture
def room():
    return TaughtRoom()


def removed(instance_id, merged_into=0):
    gone = instance(instance_id, ROOM[instance_id - 1], state=REMOVED)
    return replace(gone, merged_into=merged_into)


def moved(things, instance_id, by_m):
    thing = things[instance_id - 1]
    low, high = (tuple(np.add(corner, by_m)) for corner in thing[1:])
    return (*things[: instance_id - 1], Thing(thing.name, low, high), *things[instance_id:])


def test_without_names_nothing_changes(room):
    assert room.seen is room.bare
    assert room.seen.names is NO_NAMES


def test_a_thing_is_called_what_it_was_taught(room):
    room.teach(RED_CUP, MUG)
    label = room.label(RED_CUP)
    assert (label.name, label.p, label.source) == (MUG, 0.99, TAUGHT)
    assert room.label(BLUE_CUP).source == ENCODER


def test_a_look_alike_of_an_individual_is_only_like_it(room):
    room.teach(CHAIRS[0], "Anna's chair")
    for other in CHAIRS[1:]:
        assert room.label(other).source == ENCODER
        (last,) = room.seen.names.like[room.seen.find(other)]
        assert (last.name, last.source) == ("like Anna's chair", INHERITED)


def test_look_alikes_inherit_the_name_of_a_category(room):
    room.teach(CHAIRS[0], "windsor")
    for other in CHAIRS[1:]:
        label = room.label(other)
        assert (label.name, label.source) == ("windsor", INHERITED)
        expected = room.album.judgement.of_category(np.array([label.cosine]))[0]
        assert label.p == pytest.approx(expected)
        assert 0.5 <= label.p <= 0.99
    assert room.label(BOX).source == ENCODER


def test_what_was_taught_a_category_of_its_own_inherits_none(room):
    room.teach(CHAIRS[0], "windsor")
    room.teach(CHAIRS[1], "thonet")
    assert room.label(CHAIRS[1]).name == "thonet"
    assert room.label(CHAIRS[2]).source == INHERITED


def test_an_individual_name_goes_before_that_of_a_category(room):
    room.teach(CHAIRS[0], "Anna's chair")
    room.teach(CHAIRS[0], "windsor")
    assert room.label(CHAIRS[0]).name == "Anna's chair"
    assert room.label(CHAIRS[1]).name == "windsor"


def test_an_encoder_that_was_never_measured_passes_nothing_on():
    room = TaughtRoom(judgement=Judgement())
    room.teach(CHAIRS[0], "windsor")
    assert room.label(CHAIRS[0]).source == TAUGHT
    assert room.label(CHAIRS[1]).source == ENCODER


def test_walls_inherit_nothing(room):
    room.teach(CHAIRS[0], "windsor")
    wall = replace(room.bare.columns, role=np.array(["wall"] * len(room.bare)))
    room.bare = replace(room.bare, columns=wall)
    assert room.label(CHAIRS[1]).source == ENCODER


def test_a_name_of_an_individual_is_that_of_one_thing(room):
    first = room.teach(RED_CUP, MUG)
    room.teach(BLUE_CUP, "Aunt Mary’s mug!")
    assert first not in room.book.taught
    assert room.label(RED_CUP).source == ENCODER
    assert room.label(BLUE_CUP).source == TAUGHT


def test_a_category_may_be_taught_with_many_things(room):
    room.teach(CHAIRS[0], "windsor")
    room.teach(CHAIRS[1], "windsor")
    room.teach(CHAIRS[1], "windsor")
    assert len(room.book.taught) == 2
    assert [room.label(key).source for key in CHAIRS] == [TAUGHT, TAUGHT, INHERITED]


def test_a_name_taken_back_leaves_nothing(room):
    before = room.seen
    taught = room.teach(RED_CUP, MUG)
    assert room.book.names_of(RED_CUP) == (taught,)
    room.book.forget(room.book.called("AUNT MARY'S MUG"))
    assert room.book.names_of(RED_CUP) == ()
    assert room.seen is before


def test_a_name_follows_a_merge_and_what_that_is_merged_into(room):
    room.teach(RED_CUP, MUG)
    room.book.follow(5, [removed(RED_CUP, BLUE_CUP), removed(BLUE_CUP, BOX)])
    room.book.settle(room.bare, room.album)
    assert room.label(BOX).name == MUG
    assert [one.spot.instance_id for one in room.book.take_moved()] == [BOX]
    assert room.book.take_moved() == ()


def test_a_merge_in_another_map_means_other_things(room):
    room.teach(RED_CUP, MUG)
    room.book.follow(6, [removed(RED_CUP, BLUE_CUP)])
    assert room.book.taught[0].spot.instance_id == RED_CUP


def test_merges_in_a_circle_end(room):
    room.teach(RED_CUP, MUG)
    room.book.follow(5, [removed(RED_CUP, BLUE_CUP), removed(BLUE_CUP, RED_CUP)])
    assert room.book.taught[0].spot.instance_id in (RED_CUP, BLUE_CUP)


def test_a_new_map_gives_other_ids_and_the_name_finds_its_thing(room):
    taught = room.teach(RED_CUP, MUG)
    room.map(ROOM[::-1], epoch=6)
    held = room.book.held(taught)
    assert held.instance_id == len(ROOM) + 1 - RED_CUP
    assert held.p > 0.99
    (written,) = room.book.take_moved()
    assert (written.spot.instance_id, written.spot.map_epoch) == (held.instance_id, 6)


def test_what_is_not_where_it_was_is_unattached_and_comes_back(room):
    taught = room.teach(RED_CUP, MUG)
    room.map(moved(ROOM, RED_CUP, (1.0, 0.0, 0.0)), epoch=6)
    assert room.book.held(taught) is None
    assert room.book.taught == (taught,)
    (given,) = room.seen.names.given[MUG.lower()]
    assert given.p == {}
    assert "nothing in this map is that now" in given.reason
    room.map(ROOM, epoch=7)
    assert room.book.held(taught).instance_id == RED_CUP


def test_a_doubtful_find_is_shown_with_its_p_but_not_written_down(room):
    taught = room.teach(RED_CUP, MUG)
    room.map(moved(ROOM, RED_CUP, (0.065, 0.0, 0.0)), epoch=6)
    held = room.book.held(taught)
    assert 0.5 < held.p < 0.9
    assert room.label(RED_CUP).p == pytest.approx(0.99 * held.p)
    (given,) = room.seen.names.given[MUG.lower()]
    assert given.reason.endswith(f"UTC, this is it with p {0.99 * held.p:.2f}")
    assert room.book.take_moved() == ()


def test_looks_of_two_encoders_are_not_compared(room):
    taught = room.teach(CHAIRS[0], "windsor")
    room.book.forget([taught])
    room.book.teach(replace(taught, looks=replace(taught.looks, model_id="other")))
    assert room.label(CHAIRS[0]).source == TAUGHT
    assert room.label(CHAIRS[1]).source == ENCODER


def test_after_a_change_of_the_encoder_what_was_taught_is_seen_anew(room):
    taught = room.teach(CHAIRS[0], "windsor")
    room.book.forget([taught])
    room.book.teach(replace(taught, looks=replace(taught.looks, model_id="other")))
    room.map(ROOM, epoch=6)
    assert room.book.held(taught).p == pytest.approx(1.0)
    (anew,) = room.book.take_seen_anew()
    assert (anew.looks.model_id, anew.number) == ("words", taught.number)
    assert room.label(CHAIRS[1]).source == INHERITED


def test_a_thing_that_moves_takes_its_name_along(room):
    taught = room.teach(RED_CUP, MUG)
    room.map(moved(ROOM, RED_CUP, (1.0, 0.0, 0.0)))
    assert room.book.held(taught).p == 1.0
    (written,) = room.book.take_moved()
    assert written.spot.centre_world[0] == pytest.approx(taught.spot.centre_world[0] + 1.0)


def test_a_small_move_is_not_worth_writing_down(room):
    room.teach(RED_CUP, MUG)
    room.map(moved(ROOM, RED_CUP, (0.1, 0.0, 0.0)))
    assert room.book.take_moved() == ()


def test_an_empty_map_holds_nothing(room):
    taught = room.teach(RED_CUP, MUG)
    room.map((), epoch=6)
    assert room.book.held(taught) is None
    assert len(room.seen) == 0


def test_names_know_who_and_when(room):
    taught = room.teach(RED_CUP, MUG)
    assert taught.told == "taught by anna on 2026-11-22 16:05 UTC"
    assert when(STAMP_NS) == "2026-11-22 16:05 UTC"
    assert (taught.kind, room.teach(BOX, "bread bin").kind) == (INDIVIDUAL, CATEGORY)


def test_the_stream_of_labels_says_what_was_taught_and_takes_it_back(room):
    board = LabelBoard(ROUTER.namer)
    board.update(room.bare)
    room.teach(RED_CUP, MUG)
    (told,) = board.update(room.seen).labels
    assert told == InstanceLabel(RED_CUP, MUG, 0.99, accepted=True, source=TAUGHT)
    room.book.forget(room.book.taught)
    (told,) = board.update(room.seen).labels
    assert told.source == ENCODER


def test_a_reasoner_may_add_to_a_taught_name_but_not_replace_it(room):
    room.teach(RED_CUP, MUG)
    row = room.bare.find(RED_CUP)
    guessed = ROUTER.namer.label(room.bare, row, 1).labels[0].name
    naming = ROUTER.namer.conclude(room.seen, row, LabelVerdict(((guessed, 1.0),), "seen", 1))
    assert [label.name for label in naming.labels] == [MUG, guessed]
    assert (naming.status, naming.route) == ("found", "reasoned")
    assert naming.reason == f"'{MUG}' was taught by anna on 2026-11-22 16:05 UTC"


def test_more_than_so_many_look_alikes_do_not_inherit():
    things = tuple(Thing("pebble", (0.3 * i, 0, 0), (0.3 * i + 0.1, 0.1, 0.1)) for i in range(250))
    room = TaughtRoom(things)
    room.teach(1, "gravel")
    heirs = [one for one in room.seen.instances if one.label.source == INHERITED]
    assert len(heirs) in (MAX_HEIRS - 1, MAX_HEIRS)
    others = room.album.cosines(room.book.taught[0], room.bare.columns.instance_id.astype(int))
    assert min(one.label.cosine for one in heirs) >= np.sort(others)[-MAX_HEIRS]
