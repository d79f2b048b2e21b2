"""Which items changed when: what a reader missed, or that nobody knows."""

from hypothesis import given
from hypothesis import strategies as st

from sceneq_nodes._changes import Changes


def test_nothing_is_known_from_before() -> None:
    changes = Changes(5)
    assert changes.after(4) is None
    assert changes.after(5) == []


@given(st.lists(st.sets(st.integers(0, 9)), max_size=12), st.integers(0, 12))
def test_it_tells_what_was_told_of_since(told: list[set[int]], after: int) -> None:
    changes = Changes()
    for seq, ids in enumerate(told, 1):
        changes.note(seq, ids)
    assert changes.after(after) == sorted(set().union(*told[after:]))
