"""A scene graph does not depend on how the world is turned."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from support.sheets import GraphedRoom, furnished_room

AS_BUILT = GraphedRoom(furnished_room()).relations()


@settings(max_examples=6, deadline=None, derandomize=True)
@given(st.floats(-180, 180))
def test_turning_about_gravity_changes_nothing(angle_deg):
    turn = Rotation.from_euler("z", angle_deg, degrees=True).as_matrix()
    assert GraphedRoom(furnished_room(), turn).relations() == AS_BUILT


def test_up_may_be_any_axis():
    for axis in "xy":
        for angle_deg in (90, -90):
            turn = Rotation.from_euler(axis, angle_deg, degrees=True).as_matrix()
            assert GraphedRoom(furnished_room(), turn).relations() == AS_BUILT


def test_the_same_room_gives_the_same_graph():
    again = GraphedRoom(furnished_room()).relations()
    assert again == AS_BUILT
    assert np.array_equal(sorted(again), sorted(AS_BUILT))
