"""Whatever people type is read or refused, and reading does not depend on how it is written."""

from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.routing.phrase import read
from sceneq_core.routing.words import RELATIONS

nouns = st.sampled_from(["cup", "coffee table", "red box", "sofa", "trash can"])


@given(st.text(max_size=1000))
def test_any_text_is_read_or_refused(text):
    try:
        phrase = read(text)
    except ValueError:
        return
    assert len(phrase.constraints) <= 4
    assert len(phrase.target) <= 3 * len(text)


@given(nouns, st.sampled_from(sorted(RELATIONS)), nouns)
def test_every_relation_word_separates_target_and_anchor(target, word, anchor):
    phrase = read(f"where is the {target} {word} the {anchor}?")
    assert phrase.target == target
    assert [(c.relation, c.anchor) for c in phrase.constraints] == [(RELATIONS[word], anchor)]


@given(nouns, st.sampled_from(["{}", "the {}", "Where is the {}?", "  SHOW me a {} ", "find {}."]))
def test_frames_around_a_thing_do_not_matter(target, frame):
    assert read(frame.format(target)) == read(target)
