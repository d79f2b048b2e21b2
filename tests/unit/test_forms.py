"""The forms of a question, read."""

import pytest

from sceneq_core.routing.forms import (
    COUNT,
    EXISTS,
    FIND,
    WHAT,
    WHEN,
    WHERE,
    Form,
    read_form,
)
from sceneq_core.routing.phrase import MAX_CHARS


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("red mug", FIND),
        ("the chair left of the desk", FIND),
        ("where can I sit", FIND),
        ("something to sit on", FIND),
        ("where is the mug?", WHERE),
        ("Please, where are my keys", WHERE),
        ("what is on the table?", WHAT),
        ("what's next to the sink", WHAT),
        ("anything under the sofa", WHAT),
        ("what is between the sofa and the table", WHAT),
        ("is there a fire extinguisher?", EXISTS),
        ("are there any chairs", EXISTS),
        ("do you see a cup on the desk", EXISTS),
    ],
)
def test_the_whole_text_is_one_question(text, kind):
    assert read_form(text) == Form(kind, (text,))


@pytest.mark.parametrize(
    ("text", "kind", "part"),
    [
        ("how many chairs?", COUNT, "chairs"),
        ("How many chairs are there in the room?", COUNT, "chairs in the room"),
        ("how many cups are on the table", COUNT, "cups on the table"),
        ("how many red boxes do you see", COUNT, "red boxes"),
        ("count the chairs", COUNT, "chairs"),
        ("when did you last see the keys?", WHEN, "the keys"),
        ("when were the keys last seen", WHEN, "the keys"),
        ("how long ago did you see my phone", WHEN, "my phone"),
    ],
)
def test_only_the_thing_is_left_of_the_question(text, kind, part):
    assert read_form(text) == Form(kind, (part,))


@pytest.mark.parametrize(
    ("text", "kind", "parts"),
    [
        ("the mug and the plate", FIND, ("the mug", "the plate")),
        ("mug, plate and bowl", FIND, ("mug", "plate", "bowl")),
        ("where are the mug and the plate?", WHERE, ("the mug", "the plate?")),
        ("how many chairs and tables are there", COUNT, ("chairs", "tables")),
        ("the cup on the desk and the lamp", FIND, ("the cup on the desk", "the lamp")),
    ],
)
def test_several_things_are_several_questions(text, kind, parts):
    assert read_form(text) == Form(kind, parts)


@pytest.mark.parametrize(
    "text",
    [
        "the chair between the sofa and the table",
        "the red and white mug",
        "the cup on the table and next to the lamp",
        "facing the window, the chair on the left",
        "a and b and c and d and e",
        "mug and",
        "and",
    ],
)
def test_and_does_not_always_separate_things(text):
    assert read_form(text) == Form(FIND, (text,))


@pytest.mark.parametrize("text", ["how many", "where", "is there", "when was", "count"])
def test_an_opening_alone_is_a_thing(text):
    assert read_form(text) == Form(FIND, (text,))


@pytest.mark.parametrize("text", ["", " \n", "?!", "how many ?" + " " * MAX_CHARS])
def test_what_is_no_question_is_refused(text):
    with pytest.raises(ValueError, match="question"):
        read_form(text)
