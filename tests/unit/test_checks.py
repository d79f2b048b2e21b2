"""Limits of parameters: what is inside passes, what is outside is named."""

from dataclasses import dataclass

import pytest

from sceneq_core.checks import need_at_least, need_between, need_positive, need_within

NAN = float("nan")


@dataclass(frozen=True, slots=True)
class Params:
    good: float
    size: float


@pytest.mark.parametrize(
    ("need", "limits", "inside", "outside"),
    [
        (need_positive, (), (1e-9, 1, float("inf")), (0, -1, NAN)),
        (need_at_least, (2,), (2, 3), (1.99, NAN)),
        (need_within, (0, 1), (0, 0.5, 1), (-0.01, 1.01, NAN)),
        (need_between, (0, 1), (0.01, 0.99), (0, 1, NAN)),
    ],
)
def test_limits_hold_and_name_the_field(need, limits, inside, outside):
    for value in inside:
        assert need(Params(good=0.5, size=value), *limits, "size") is None
    for value in outside:
        with pytest.raises(ValueError, match=f"^size: must be .* got {value}$"):
            need(
                Params(good=2.0 if need is need_at_least else 0.5, size=value),
                *limits,
                "good",
                "size",
            )
