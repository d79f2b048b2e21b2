"""Which choice a reply makes, in the many ways models say it, and when it makes none."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.reasoning.answer_parser import UnusableReplyError, read_choice

KEYS = ("1", "2", "3", "none")
LABELS = ("coffee mug", "cup", "bowl")


@pytest.mark.parametrize(
    ("reply", "key"),
    [
        ('{"choice": "2"}', "2"),
        ('{"choice": 2}', "2"),
        ('{"choice": "none"}', "none"),
        ('{"choice": "None."}', "none"),
        ('{"choice": "Coffee Mug"}', "1"),
        ('```json\n{"choice": "3"}\n```', "3"),
        ('Sure! {"choice": "1", "why": "it is red"} Anything else?', "1"),
        ('{"choice": "1"} no, wait: {"choice": "2"}', "2"),
        ('{"reason": "x"} so 3', "3"),
        ('<think>box 1? or {"choice": "2"}?</think>{"choice": "3"}', "3"),
        ("2", "2"),
        (" 2.\n", "2"),
        ('"3"', "3"),
        ("cup", "2"),
        ("Coffee mug.", "1"),
        ("NONE", "none"),
        ("Box 3", "3"),
        ("The answer is 2.", "2"),
        ("**Answer:** 2", "2"),
        ("There are 3 mugs on the 1 table; the answer is box 2", "2"),
        ("Choice: none of them", "none"),
        ("It must be 2, I think. Yes, 2", "2"),
        ("none of the boxes shows a unicorn", "none"),
        ("2 2 2 2 2", "2"),
        ('{"choice": ["2"]}', "2"),
        ("Box 1 is a bowl, box 2 a jug. Answer: 3", "3"),
        ('{"choice": "2"', "2"),  # cut off by max_tokens, but said
    ],
)
def test_a_choice_is_read(reply, key):
    assert read_choice(reply, KEYS, LABELS) == key


@pytest.mark.parametrize(
    ("reply", "problem"),
    [
        ("", "names no choice"),
        ("I am not sure.", "names no choice"),
        ('{"answer": true}', "names no choice"),
        ('{"choice": "7"}', "'7' is not in the list"),
        ('{"choice": "2 or 3"}', "'2 or 3' is not in the list"),
        ("The answer is 7", "'7' is not in the list"),
        ("Answer: 12", "'12' is not in the list"),
        ("1 or 2", "several choices: 1, 2"),
        ("The answer is 1. No: the answer is 2", "several choices: 1, 2"),
        ("box 1 is a cup, box 2 is a mug", "several"),
        ("it is 1.5 m high", "names no choice"),
        ("<think>box 1, I guess", "names no choice"),
    ],
)
def test_what_is_no_choice_is_said(reply, problem):
    with pytest.raises(UnusableReplyError, match=problem):
        read_choice(reply, KEYS, LABELS)


def test_of_a_long_reply_the_end_counts():
    assert read_choice("box 1. " * 5000 + "Answer: 3", KEYS) == "3"


@given(st.text(alphabet='{}"123 :,choiceansrbx.\n[]none<think>/', max_size=80))
def test_nothing_outside_the_list_is_ever_chosen(reply):
    with suppress(UnusableReplyError):
        assert read_choice(reply, KEYS, LABELS) in KEYS


@given(st.sampled_from(KEYS), st.text(max_size=30).filter(lambda t: "{" not in t and "<" not in t))
def test_json_is_found_within_any_talk(key, talk):
    assert read_choice(f'{talk}{{"choice": "{key}"}}{talk}', KEYS) == key
