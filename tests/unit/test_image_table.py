"""Cosines with examples stay right whatever comes and goes."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from sceneq_core.teaching.image_table import UNKNOWN, ImageTable

IDS = st.integers(1, 40)
STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("put"), st.lists(IDS, min_size=1, max_size=9, unique=True)),
        st.tuples(st.just("remove"), st.lists(IDS, max_size=9)),
        st.tuples(st.just("compare"), st.lists(st.integers(0, 3), max_size=2)),
        st.tuples(st.just("keep"), st.lists(st.integers(0, 3), max_size=2)),
    ),
    max_size=12,
)
EXAMPLES = np.random.default_rng(1).standard_normal((4, 5)).astype(np.float32)


@settings(deadline=None)
@given(steps=STEPS)
def test_it_knows_what_a_plain_dictionary_knows(steps):
    rng = np.random.default_rng(0)
    table, plain = ImageTable(), {}
    ids = np.arange(50)
    for what, keys in steps:
        if what == "put":
            new = {key: rng.standard_normal(5).astype(np.float32) for key in keys}
            table.put(new)
            plain |= new
        elif what == "remove":
            table.remove(keys)
            plain = {key: value for key, value in plain.items() if key not in keys}
        elif what == "keep":
            table.keep_examples(keys)
        else:
            for number in keys:
                table.cosines(number, EXAMPLES[number], ids)
    for number, example in enumerate(EXAMPLES):
        expected = [plain[key] @ example if key in plain else UNKNOWN for key in ids]
        got = table.cosines(number, example, ids)
        np.testing.assert_allclose(got, expected, rtol=1e-5, atol=1e-5)


def test_vectors_of_other_lengths_are_not_compared():
    table = ImageTable()
    table.put({3: np.ones(5, np.float32), 4: np.ones(6, np.float32)})
    assert table.cosines(0, np.ones(5, np.float32), np.array([3])).tolist() in ([5.0], [UNKNOWN])
    assert table.cosines(1, np.ones(9, np.float32), np.array([3, 4])).tolist() == [UNKNOWN] * 2
    table.put({})
    assert ImageTable().cosines(0, np.ones(5, np.float32), np.array([1])).tolist() == [UNKNOWN]
