"""Plain values make the same parameters as pydantic does, or none."""

import subprocess
import sys
from dataclasses import dataclass, field
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter

from sceneq_nodes._plain_values import NotPlainError, make


@dataclass(frozen=True, slots=True)
class Inner:
    """A group."""

    size_m: float = 0.1

    def __post_init__(self) -> None:
        if self.size_m <= 0:
            raise ValueError("size_m: must be positive")


@dataclass(frozen=True, slots=True)
class Params:
    """Something of every kind."""

    count: int = 1
    size_m: float = 1.0
    name: str = ""
    loop: bool = False
    rate_hz: float | None = None
    inner: Inner = field(default_factory=Inner)
    backend: dict[str, Any] = field(default_factory=dict)
    names: tuple[str, ...] = ()


VALUES = (
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=3)
)
NESTED = VALUES | st.dictionaries(st.sampled_from(["size_m", "kind"]), VALUES, max_size=2)


@given(
    st.dictionaries(
        st.sampled_from(["count", "size_m", "name", "loop", "rate_hz", "inner", "backend"]),
        NESTED,
        max_size=4,
    )
)
def test_what_is_made_is_what_pydantic_makes(values: dict[str, Any]) -> None:
    try:
        made = make(Params, values)
    except NotPlainError:
        return
    assert repr(made) == repr(TypeAdapter(Params).validate_python(values))


def test_plain_values_are_made() -> None:
    values = {"size_m": 2, "rate_hz": 0, "inner": {"size_m": 0.5}, "backend": {"kind": "a"}}
    made = make(Params, values)
    assert made == Params(size_m=2.0, rate_hz=0.0, inner=Inner(0.5), backend={"kind": "a"})
    assert type(made.rate_hz) is float
    assert make(Params, {"rate_hz": None}) == Params()


@pytest.mark.parametrize(
    "values",
    [
        {"count": True},
        {"count": 1.0},
        {"size_m": 2**53},
        {"size_m": "1"},
        {"loop": 1},
        {"inner": {"size_m": -1.0}},
        {"inner": {"colour": "red"}},
        {"names": ["a"]},
        {"unknown": 1},
        {"backend": [1]},
    ],
)
def test_the_rest_is_left_to_pydantic(values: dict[str, Any]) -> None:
    with pytest.raises(NotPlainError):
        make(Params, values)


def test_a_node_starts_without_pydantic() -> None:
    """What a default graph gives its nodes is plain; pydantic costs a restarted node time."""
    code = (
        "import sys; from sceneq_nodes import _process; from sceneq_nodes._backends import load;"
        "from sceneq_nodes._params import validate;"
        "validate(load('nodes', 'routing').Params, {'encoder': {'kind': 'conse'}});"
        "sys.exit('pydantic' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
