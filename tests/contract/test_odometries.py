"""What every odometry promises."""

import numpy as np
import pytest

from sceneq_core.ingest.transforms import rigid_defect
from sceneq_nodes._backends import build, kinds

from support.room import Room

KINDS = sorted(kinds("odometry"))
ROOM = Room(size=(160, 120), focal_px=130.0)
STEP_NS = 33_000_000


def poses(kind: str, views: list[int]) -> list[np.ndarray | None]:
    odometry = build("odometry", {"kind": kind})
    images = [ROOM.frame(view, 60)[1] for view in views]
    return [odometry.register(image, ROOM.K, i * STEP_NS) for i, image in enumerate(images)]


@pytest.mark.parametrize("kind", KINDS)
def test_poses_are_rigid_and_start_at_the_origin(kind: str) -> None:
    found = poses(kind, [0, 1, 2])
    assert all(T is not None and T.shape == (4, 4) and not rigid_defect(T) for T in found)
    np.testing.assert_allclose(found[0], np.eye(4), atol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_a_camera_that_stands_stays_where_it_is(kind: str) -> None:
    *_, last = poses(kind, [7] * 5)
    np.testing.assert_allclose(last, np.eye(4), atol=0.01)


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_images_give_the_same_bits(kind: str) -> None:
    one, two = poses(kind, [0, 1, 2, 3]), poses(kind, [0, 1, 2, 3])
    assert [T.tobytes() for T in one] == [T.tobytes() for T in two]


@pytest.mark.parametrize("kind", KINDS)
def test_it_says_when_it_cannot_tell_and_goes_on(kind: str) -> None:
    odometry = build("odometry", {"kind": kind})
    depth_mm = ROOM.frame(0, 60)[1]
    assert odometry.register(np.zeros_like(depth_mm), ROOM.K, 0) is None
    assert odometry.register(depth_mm, ROOM.K, STEP_NS) is not None
    assert odometry.kind == kind
