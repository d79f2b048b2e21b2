"""Constraints on their way to the reasoner."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.reasoning.reasoner import Constraint
from sceneq_nodes._constraint_json import MAX_RANK, constraint_from_json, constraint_json
from sceneq_schemas.errors import DecodeError

texts = st.text(max_size=20)
constraints = st.builds(
    Constraint,
    relation=texts,
    anchor=texts,
    other=texts,
    rank=st.integers(1, MAX_RANK),
    seen_from=texts,
    facing=texts,
    negated=st.booleans(),
)


@given(constraints)
def test_a_constraint_comes_back(constraint):
    wire = json.loads(json.dumps(constraint_json(constraint)))
    assert constraint_from_json(wire) == constraint


def test_a_plain_one_is_as_short_as_ever():
    assert constraint_json(Constraint("on", "table")) == ["on", "table"]
    assert constraint_json(Constraint("leftmost", "", rank=2)) == ["leftmost", "", {"rank": 2}]


@pytest.mark.parametrize(
    "wire",
    [
        None,
        ["on"],
        ["on", 1],
        ["on", "table", 2],
        ["on", "table", {}, {}],
        ["on", "table", {"rank": 0}],
        ["on", "table", {"rank": MAX_RANK + 1}],
        ["on", "table", {"rank": True}],
        ["on", "table", {"negated": 1}],
        ["on", "table", {"other": None}],
        ["on", "table", {"relation": "in"}],
    ],
)
def test_what_is_no_constraint_is_refused(wire):
    with pytest.raises(DecodeError, match="constraints"):
        constraint_from_json(wire)
