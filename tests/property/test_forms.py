"""Whatever people type is read in some form or refused; reading is stable."""

from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.reasoning.english import plural, singular
from sceneq_core.routing.forms import FORMS, MAX_PARTS, OPENINGS, read_form
from sceneq_core.routing.phrase import MAX_RELATIONS, read
from sceneq_core.routing.words import RELATIONS, STANDPOINTS, TURNED

WORDS = sorted(
    {word for phrase in (*OPENINGS, *RELATIONS, *STANDPOINTS, *TURNED) for word in phrase.split()}
    | {"and", "not", "red", "small", "cup", "table", "second", "largest", "the", ",", "between"}
)
sentences = st.lists(st.sampled_from(WORDS), min_size=1, max_size=12).map(" ".join)
nouns = st.sampled_from(["cup", "coffee table", "trash can", "box", "knife", "shelf", "glass"])


@given(st.one_of(st.text(max_size=1000), sentences))
def test_any_text_is_read_or_refused(text):
    try:
        form = read_form(text)
    except ValueError:
        return
    assert form.kind in FORMS
    assert 1 <= len(form.parts) <= MAX_PARTS
    assert read_form(text) == form
    for part in form.parts:
        phrase = read(part)
        assert len(phrase.constraints) <= MAX_RELATIONS + 1
        assert read(part) == phrase


@given(sentences.filter(lambda text: any(word != "," for word in text.split())))
def test_white_space_and_case_do_not_matter(text):
    assert read(f"  {text.upper()}  ") == read(text)


@given(nouns, nouns)
def test_two_things_come_back_as_two_questions(one, other):
    assert read_form(f"the {one} and the {other}").parts == (f"the {one}", f"the {other}")


@given(nouns)
def test_what_is_counted_is_one_of_them(noun):
    (part,) = read_form(f"how many {plural(noun)} are there?").parts
    assert singular(read(part).target) == noun
