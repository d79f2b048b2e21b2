"""Rigid motions form a group, and the functions on them respect it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sceneq_core.ingest.transforms import (
    angle_deg,
    distance_m,
    inverse,
    nearest_rigid,
    rigid_defect,
    transform,
)

METRES = st.floats(-20, 20)
RADIANS = st.floats(-1.8, 1.8)
VECTORS = st.tuples(METRES, METRES, METRES)


@st.composite
def motions(draw) -> np.ndarray:
    T_b_a = np.eye(4)
    T_b_a[:3, :3] = Rotation.from_rotvec(draw(st.tuples(RADIANS, RADIANS, RADIANS))).as_matrix()
    T_b_a[:3, 3] = draw(VECTORS)
    return T_b_a


def close(a: np.ndarray, b: np.ndarray) -> bool:
    return np.allclose(a, b, rtol=1e-7, atol=1e-9)


@given(motions(), motions())
def test_products_and_inverses_are_rigid(a: np.ndarray, b: np.ndarray) -> None:
    assert rigid_defect(a @ b) is None
    assert rigid_defect(inverse(a)) is None
    assert close(nearest_rigid(a), a)


@given(motions(), motions())
def test_inverse_laws(a: np.ndarray, b: np.ndarray) -> None:
    assert close(a @ inverse(a), np.eye(4))
    assert close(inverse(a) @ a, np.eye(4))
    assert close(inverse(inverse(a)), a)
    assert close(inverse(a @ b), inverse(b) @ inverse(a))


@given(motions(), motions(), VECTORS)
def test_transforming_is_a_group_action(a: np.ndarray, b: np.ndarray, point: tuple) -> None:
    points = np.array([point])
    assert close(transform(a, transform(b, points)), transform(a @ b, points))
    assert close(transform(inverse(a), transform(a, points)), points)


@given(motions(), motions(), motions())
def test_distance_and_angle_do_not_depend_on_the_world(
    world: np.ndarray, a: np.ndarray, b: np.ndarray
) -> None:
    assert close(distance_m(world @ a, world @ b), distance_m(a, b))
    assert angle_deg(world @ a, world @ b) == pytest.approx(angle_deg(a, b), abs=1e-5)
    assert angle_deg(a, b) == pytest.approx(angle_deg(b, a), abs=1e-5)
    assert 0 <= angle_deg(a, b) <= 180
