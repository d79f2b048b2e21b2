"""What counts as a rigid motion, and how far apart two poses are."""

import numpy as np
import pytest

from sceneq_core.ingest.transforms import angle_deg, distance_m, nearest_rigid, rigid_defect


def turned(degrees: float) -> np.ndarray:
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]])


@pytest.mark.parametrize(
    ("matrix", "defect"),
    [
        (np.eye(3), "expected 4x4"),
        (np.full((4, 4), np.nan), "not finite"),
        (np.ones((4, 4)), "last row"),
        (np.diag([1.01, 1, 1, 1]), "not rigid"),
        (np.diag([1e200, 1, 1, 1]), "not rigid"),
        (np.diag([1.0, 1, -1, 1]), "reflection"),
        (np.zeros((4, 4)) + np.diag([0, 0, 0, 1.0]), "not rigid"),
    ],
)
def test_defects(matrix: np.ndarray, defect: str) -> None:
    assert defect in (rigid_defect(matrix) or "none")


def test_a_pose_rounded_to_four_digits_is_rigid_and_can_be_made_exact() -> None:
    rounded = np.round(turned(33.0), 4)
    assert rigid_defect(rounded) is None
    exact = nearest_rigid(rounded)
    np.testing.assert_allclose(exact[:3, :3].T @ exact[:3, :3], np.eye(3), atol=1e-15)
    np.testing.assert_allclose(exact, turned(33.0), atol=1e-4)


@pytest.mark.parametrize("degrees", [0.0, 1e-6, 30.0, 90.0, 179.0])
def test_angle(degrees: float) -> None:
    assert angle_deg(turned(10.0), turned(10.0 + degrees)) == pytest.approx(degrees, abs=1e-9)


def test_distance_is_between_the_origins() -> None:
    moved = turned(50.0)
    moved[:3, 3] = (3.0, 0.0, 4.0)
    assert distance_m(np.eye(4), moved) == 5.0
