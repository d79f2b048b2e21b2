"""Every message that can be built comes back from its bytes, bit by bit."""

import types
from dataclasses import fields, is_dataclass
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from sceneq_schemas.codec import decode, encode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import TOPICS

from support.messages import same

MESSAGES = sorted({t.message for t in TOPICS if t.message is not None}, key=lambda c: c.__name__)

SCALARS: dict[Any, st.SearchStrategy[Any]] = {
    int: st.integers(-(2**63), 2**63 - 1),
    float: st.floats(),
    bool: st.booleans(),
    str: st.text(max_size=12),
    bytes: st.binary(max_size=12),
}


def values(hint: Any) -> st.SearchStrategy[Any]:
    """Return a strategy for anything a field of type ``hint`` may hold."""
    origin, args = get_origin(hint), get_args(hint)
    if origin is Annotated:
        spec = args[1]
        shape = st.tuples(*(st.integers(0, 3) if n is None else st.just(n) for n in spec.shape))
        return shape.flatmap(lambda s: hnp.arrays(np.dtype(spec.dtype), s))
    if origin in (Union, types.UnionType):
        return st.none() | values(args[0])
    if origin is tuple:
        return st.lists(values(args[0]), max_size=3).map(tuple)
    if is_dataclass(hint):
        return messages(hint)
    return SCALARS[hint]


def messages(cls: Any) -> st.SearchStrategy[Any]:
    hints = get_type_hints(cls, include_extras=True)
    return st.builds(cls, **{f.name: values(hints[f.name]) for f in fields(cls)})


@pytest.mark.parametrize("cls", MESSAGES, ids=lambda cls: cls.__name__)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_round_trip(cls: Any, data: st.DataObject) -> None:
    message = data.draw(messages(cls))
    wire = encode(message)
    again = decode(cls, wire)
    assert same(again, message)
    assert encode(again) == wire


@settings(max_examples=200, deadline=None)
@given(junk=st.binary(max_size=200), cls=st.sampled_from(MESSAGES))
def test_junk_is_refused_by_name_or_is_a_message_after_all(junk: bytes, cls: Any) -> None:
    result = decoded_or_refused(cls, junk)
    if isinstance(result, str):
        assert result.startswith(cls.__name__)
    else:
        assert same(decode(cls, encode(result)), result)


def decoded_or_refused(cls: Any, junk: bytes) -> Any:
    try:
        return decode(cls, junk)
    except DecodeError as error:
        return str(error)
