"""What names a thing, and what describes it."""

import pytest

from sceneq_core.routing.described_words import describes, wants_to_do

from support.furnished import router

READER = router()


@pytest.mark.parametrize(
    "text",
    [
        "something to sit on",
        "somewhere to lie down",
        "a place to keep books",
        "where can I keep milk cold",
        "please, where do I throw away garbage?",
        "something made of wicker",
        "something that tells the time",
        "an instrument to play music on",
        "somewhere several people can sit together",
    ],
)
def test_words_that_describe_the_target(text):
    question = READER.read(text)
    assert question.wanted[question.phrase.target].described


@pytest.mark.parametrize(
    "text",
    [
        "chair",
        "where can I find the red mug",
        "where is the bottle of wine",
        "the box that is on the table",
        "the lamp next to the sofa",
        "cup and saucer",
        "something red",
        "the second chair from the left",
        "which chair is the closest to the door",
    ],
)
def test_words_that_name_the_target(text):
    question = READER.read(text)
    assert not question.wanted[question.phrase.target].described


def test_an_anchor_may_be_described_too():
    wanted = READER.read("the lamp next to something to sit on").wanted
    assert [one.described for one in wanted.values()] == [False, True]


def test_words_for_anything_alone_describe_nothing():
    assert not describes("something")
    assert not describes("")
    assert not wants_to_do("where can I")
