"""Whatever the candidates: the choice is bounded, distinct, and does not depend on the losers."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.views.choice import Candidates, ChoiceParams, choose

PARAMS = ChoiceParams(count=3, min_visible_px=50)
ROWS = st.lists(
    st.tuples(
        st.integers(0, 500),
        st.booleans(),
        st.tuples(*[st.floats(-5, 5, allow_nan=False, width=32)] * 3),
    ),
    max_size=12,
)


def candidates(rows) -> Candidates:
    return Candidates(
        np.array([px for px, _, _ in rows], np.int64),
        np.array([cut for _, cut, _ in rows], np.bool_),
        np.array([camera for _, _, camera in rows], np.float64).reshape(-1, 3),
    )


@given(ROWS)
def test_as_many_as_there_are_but_no_more_than_count(rows):
    chosen = choose(candidates(rows), np.zeros(3), PARAMS)
    assert len(chosen) == min(3, sum(px >= 50 for px, _, _ in rows))
    assert len(set(chosen)) == len(chosen)


@given(ROWS)
def test_forgetting_the_losers_changes_nothing(rows):
    chosen = choose(candidates(rows), np.zeros(3), PARAMS)
    kept = sorted(chosen)
    again = choose(candidates([rows[k] for k in kept]), np.zeros(3), PARAMS)
    assert [kept[k] for k in again] == chosen
