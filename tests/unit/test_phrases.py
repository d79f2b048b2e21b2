import pytest

from sceneq_tools.room.category import Category
from sceneq_tools.room.truth.phrases import ABSENT, PURPOSES, could_mean


def named(label: str, *synonyms: str) -> Category:
    return Category(label, "top", "", (), synonyms, ("m",))


@pytest.mark.parametrize(
    ("phrase", "label"),
    [
        ("coffee mug", "coffee mug"),
        ("table", "coffee table"),
        ("coffee mug", "plastic cup"),
        ("chair", "armchair"),
        ("potted plant", "cactus"),
        ("bowl", "bowl of fruit"),
        ("desk lamp", "table lamp"),
        ("TV", "television"),
    ],
)
def test_names_that_do_not_tell_two_things_apart(phrase: str, label: str) -> None:
    assert could_mean(phrase, named(label))


@pytest.mark.parametrize(
    ("phrase", "label"),
    [
        ("coffee table", "dining table"),
        ("armchair", "chair"),
        ("cactus", "potted plant"),
        ("bowl of fruit", "bowl"),
        ("washing machine", "coffee machine"),
        ("gift box", "cardboard box"),
        ("wine bottle", "wine glass"),
    ],
)
def test_names_that_do(phrase: str, label: str) -> None:
    assert not could_mean(phrase, named(label))


def test_a_synonym_counts_like_the_label() -> None:
    assert could_mean("couch", named("sofa", "couch"))
    assert could_mean("computer", named("notebook", "laptop computer"))


def test_wordings_are_asked_once() -> None:
    assert len({text for text, _ in PURPOSES}) == len(PURPOSES)
    assert len(set(ABSENT)) == len(ABSENT)
