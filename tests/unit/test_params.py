"""Parameters from outside: converted, or refused with the place and a hint."""

from dataclasses import dataclass, field
from typing import Any, Literal

import pytest

from sceneq_nodes._params import ParamError, did_you_mean, validate


@dataclass(frozen=True, slots=True)
class Inner:
    """A part."""

    size_m: float = 0.1


@dataclass(frozen=True, slots=True)
class Params:
    """Something of every kind."""

    path: str
    voxel_m: float = 0.02
    count: int = 5
    mode: Literal["fast", "exact"] = "fast"
    inner: Inner = field(default_factory=Inner)
    names: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.voxel_m <= 0:
            raise ValueError(f"voxel_m {self.voxel_m} must be positive")


def test_values_are_converted_to_their_types() -> None:
    values = {"path": "a", "voxel_m": 1, "inner": {"size_m": "0.5"}, "names": ["x", "y"]}
    assert validate(Params, values) == Params("a", 1.0, 5, "fast", Inner(0.5), ("x", "y"))


def test_defaults_stay() -> None:
    assert validate(Params, {"path": "a"}) == Params("a")


@pytest.mark.parametrize(
    ("values", "says"),
    [
        ({"path": "a", "voxle_m": 1}, "p.voxle_m: unknown key (did you mean 'voxel_m'?)"),
        (
            {"path": "a", "zzz": 1},
            "p.zzz: unknown key (known: count, inner, mode, names, path, voxel_m)",
        ),
        ({}, "p.path: missing key (add 'path: ...')"),
        ({"path": "a", "count": 1.5}, "p.count: Input should be a valid integer"),
        ({"path": "a", "mode": "slow"}, "p.mode: Input should be 'fast' or 'exact'"),
        ({"path": "a", "inner": {"size_m": "big"}}, "p.inner.size_m: Input should be a valid"),
        ({"path": "a", "names": ["x", 1]}, "p.names.1: Input should be a valid string"),
        ({"path": "a", "voxel_m": -1}, "p: Value error, voxel_m -1.0 must be positive"),
    ],
)
def test_bad_values_are_named_with_their_place(values: dict[str, Any], says: str) -> None:
    with pytest.raises(ParamError) as caught:
        validate(Params, values, ("p",))
    assert str(caught.value).startswith(says)


def test_the_error_carries_its_parts() -> None:
    with pytest.raises(ParamError) as caught:
        validate(Params, {"path": "a", "count": "many"})
    error = caught.value
    assert (error.path, error.value, error.hint) == (("count",), "many", "")


def test_hints() -> None:
    assert did_you_mean("vocsel", {"voxel", "mode"}) == "did you mean 'voxel'?"
    assert did_you_mean("q", {"b", "a"}) == "known: a, b"
