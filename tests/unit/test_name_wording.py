"""Names as people write them."""

import pytest

from sceneq_core.teaching.wording import (
    CATEGORY,
    INDIVIDUAL,
    clean,
    clean_name,
    kind_of,
    speaks,
    spoken,
    thing_of,
)


@pytest.mark.parametrize(
    "name",
    ["aunt Mary's mug", "my mug", "Excalibur", "the boys' bench", "locker 12", "Anna’s cup"],
)
def test_possessives_capitals_and_numbers_name_an_individual(name):
    assert kind_of(name) == INDIVIDUAL


@pytest.mark.parametrize("name", ["espresso machine", "TV", "LED lamp", "glass", "bus stop"])
def test_other_words_name_a_category(name):
    assert kind_of(name) == CATEGORY


def test_white_space_and_articles_are_no_part_of_a_name():
    assert clean_name("  the   espresso  machine ") == "espresso machine"
    assert clean_name("An Excalibur") == "Excalibur"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no letter or digit"),
        ("?!", "no letter or digit"),
        ("a\nb", "control characters"),
        ("a\u202eb", "control characters"),
        ("x" * 65, "65 characters, the limit is 64"),
        ("x" * 5000, "5000 characters"),
    ],
)
def test_what_is_no_name_is_refused(text, message):
    with pytest.raises(ValueError, match=message):
        clean(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("lamp by the door", "reads as a relation"),
        ("salt and pepper", "reads as several things"),
        ("stuff", "could be anything"),
        ("the", "could be anything"),
        ("please", "could be anything"),
    ],
)
def test_a_name_that_is_not_one_thing_to_a_question_is_refused(text, message):
    with pytest.raises(ValueError, match=message):
        clean_name(text)


def test_a_field_is_named_in_its_error():
    with pytest.raises(ValueError, match=r"^by: "):
        clean("\x00", "by")


def test_a_question_speaks_a_name_whatever_its_case_and_apostrophe():
    assert speaks("Where is AUNT MARY’S mug?", "aunt Mary's mug")
    assert not speaks("where is the mug?", "my mug")
    assert not speaks("where are the mugs?", "mug")


def test_what_a_name_asks_for():
    assert thing_of("my mug") == "mug"
    assert thing_of("aunt Mary's mug") == "aunt mary's mug"
    assert spoken(" Anna’s  CUP! ") == "anna's cup"
