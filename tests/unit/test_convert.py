"""Core types become messages and come back the same."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from sceneq_core.mapping.delta import Instance as CoreInstance
from sceneq_core.mapping.delta import MapDelta as CoreMapDelta
from sceneq_core.views.view import View, ViewSet
from sceneq_nodes._convert import (
    map_delta_from_message,
    map_delta_message,
    view_set_from_message,
    view_set_message,
)
from sceneq_schemas.codec import decode, encode
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.map import Instance, MapDelta
from sceneq_schemas.view import ViewSet as ViewSetMessage

from support.true_map import delta, instance, voxels


def test_both_sides_of_the_map_have_the_same_fields():
    in_core = {f.name for f in fields(CoreMapDelta)}
    assert {f.name for f in fields(MapDelta)} == in_core | {"epoch", "seq"}
    assert {f.name for f in fields(Instance)} == {f.name for f in fields(CoreInstance)}


def test_a_map_delta_survives():
    original = delta(
        frame_seq=40, **voxels(range(5), (0, 1, 2, -1, 9)), instances=(instance(3, [0, 2]),)
    )
    message = decode(MapDelta, encode(map_delta_message(original, epoch=5, seq=6)))
    assert (message.epoch, message.seq, message.frame_seq) == (5, 6, 40)
    back = map_delta_from_message(message)
    for f in fields(original):
        if f.name != "instances":
            assert np.array_equal(getattr(back, f.name), getattr(original, f.name)), f.name
    (only,) = back.instances
    assert isinstance(only, CoreInstance)
    assert only.superpoint_id.tolist() == [0, 2]


@given(hnp.arrays(np.bool_, st.tuples(st.integers(0, 20), st.integers(0, 40))))
def test_a_view_set_survives_with_any_mask(mask):
    view = View(9, 90, 400, np.array([0, 2, 31, 44], np.float32), mask)
    message = decode(ViewSetMessage, encode(view_set_message(ViewSet(4, (view,)))))
    back = view_set_from_message(message)
    assert back.instance_id == 4
    assert (back.views[0].seq, back.views[0].stamp_ns, back.views[0].visible_px) == (9, 90, 400)
    assert back.views[0].box_xyxy.tolist() == [0, 2, 31, 44]
    assert back.views[0].mask.dtype == np.bool_
    assert np.array_equal(back.views[0].mask, mask)


@pytest.mark.parametrize(
    ("shape", "bits"),
    [((3, 9), bytes(5)), ((3,), bytes(3)), ((-1, 8), b""), ((10**6, 10**6), b"")],
)
def test_a_mask_of_wrong_size_is_a_decode_error(shape, bits):
    view = View(9, 90, 400, np.zeros(4, np.float32), np.ones((3, 9), np.bool_))
    message = view_set_message(ViewSet(4, (view,)))
    bad = replace(message.views[0], mask_shape=shape, mask_bits=bits)
    with pytest.raises(DecodeError, match=r"View\.mask"):
        view_set_from_message(replace(message, views=(bad,)))
