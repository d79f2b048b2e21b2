"""Laws of motions between frames, for any of them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from sceneq_core.ingest.frame_tree import FrameTree, StampedTransform
from sceneq_core.ingest.quaternion import quaternion_of, rigid_from_quaternion, slerp
from sceneq_core.ingest.transforms import inverse, rigid_defect

S = 1_000_000_000
NUMBERS = st.floats(-5, 5, width=32)
VECTORS = st.tuples(NUMBERS, NUMBERS, NUMBERS).map(np.array)
QUATERNIONS = st.integers(0, 10_000).map(lambda seed: Rotation.random(rng=seed).as_quat())
SHARES = st.floats(0, 1)


@st.composite
def trees(draw):
    """A tree of six frames that all move from second 0 to second 1."""
    tree = FrameTree()
    for child in range(1, 6):
        parent = draw(st.integers(0, child - 1))
        for stamp_ns in (0, S):
            tree.add(
                StampedTransform(
                    stamp_ns, f"f{parent}", f"f{child}", draw(VECTORS), draw(QUATERNIONS)
                )
            )
    return tree


FRAMES = st.integers(0, 5).map(lambda i: f"f{i}")
STAMPS = st.integers(0, S)


@given(trees(), FRAMES, FRAMES, FRAMES, STAMPS)
def test_ways_can_be_joined_and_gone_back(tree, a, b, c, stamp_ns):
    T_a_b, T_b_c = tree.lookup(a, b, stamp_ns), tree.lookup(b, c, stamp_ns)
    assert np.allclose(T_a_b @ T_b_c, tree.lookup(a, c, stamp_ns), atol=1e-9)
    assert np.allclose(inverse(T_a_b), tree.lookup(b, a, stamp_ns), atol=1e-9)
    assert rigid_defect(T_a_b) is None


@given(QUATERNIONS, QUATERNIONS, SHARES)
def test_slerp_is_that_of_scipy(a, b, share):
    expected = Slerp([0, 1], Rotation.from_quat([a, b]))(share).as_matrix()
    found = rigid_from_quaternion(np.zeros(3), slerp(a, b, share))[:3, :3]
    # Near a half turn both ways are equally short.
    assert np.allclose(found, expected, atol=2e-4) or abs(a @ b) < 1e-3


@given(QUATERNIONS)
def test_a_rotation_and_its_quaternion_are_one(xyzw):
    found = quaternion_of(Rotation.from_quat(xyzw).as_matrix())
    assert np.allclose(found, xyzw, atol=1e-9) or np.allclose(found, -xyzw, atol=1e-9)
    assert found[3] >= 0
