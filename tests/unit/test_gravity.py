"""Which way is up."""

import numpy as np
import pytest

from sceneq_core.mapping.gravity import Gravity, GravityParams

from support.room import look_at


def normals(direction, count, spread=0.05, seed=1):
    rng = np.random.default_rng(seed)
    noisy = np.asarray(direction, np.float64) + rng.normal(0.0, spread, (count, 3))
    return noisy / np.linalg.norm(noisy, axis=1, keepdims=True)


def tilted_camera():
    return look_at(np.array([0.0, -2.0, 1.5]), np.array([0.0, 0.0, 0.3]))


def degrees(a, b):
    return float(np.degrees(np.arccos(np.clip(a @ b, -1.0, 1.0))))


def test_without_surfaces_up_is_how_the_camera_is_held():
    gravity = Gravity(GravityParams())
    gravity.add(np.zeros((0, 3)), np.eye(4))
    assert gravity.up_world().tolist() == [0.0, -1.0, 0.0]


def test_the_floor_corrects_a_camera_that_looks_down():
    gravity = Gravity(GravityParams())
    gravity.add(normals((0, 0, 1), 2000), tilted_camera())
    gravity.add(normals((0, -1, 0), 3000), tilted_camera())
    assert degrees(gravity.up_world(), np.array([0.0, 0.0, 1.0])) < 0.5


def test_a_ceiling_counts_as_horizontal_too():
    gravity = Gravity(GravityParams())
    gravity.add(normals((0, 0, -1), 2000), tilted_camera())
    assert degrees(gravity.up_world(), np.array([0.0, 0.0, 1.0])) < 0.5


def test_a_world_with_y_down():
    gravity = Gravity(GravityParams())
    gravity.add(normals((0.02, -1, 0), 2000), np.eye(4))
    gravity.add(normals((0, 0, -1), 2000), np.eye(4))
    assert degrees(gravity.up_world(), np.array([0.02, -1.0, 0.0]) / np.hypot(0.02, 1)) < 0.5


def test_too_little_surface_does_not_decide():
    gravity = Gravity(GravityParams(min_voxels=500))
    gravity.add(normals((0, -0.8, -0.6), 100), np.eye(4))
    assert gravity.up_world().tolist() == [0.0, -1.0, 0.0]


def test_a_given_direction_wins_and_is_normalised():
    gravity = Gravity(GravityParams(up_world=(0.0, 0.0, 2.0)))
    gravity.add(normals((1, 0, 0), 2000), np.eye(4))
    assert gravity.up_world().tolist() == [0.0, 0.0, 1.0]


@pytest.mark.parametrize(
    ("values", "field"),
    [
        ({"up_world": (0.0, 0.0, 0.0)}, "up_world"),
        ({"cone_deg": 50.0}, "cone_deg"),
        ({"min_voxels": 0}, "min_voxels"),
    ],
)
def test_a_bad_parameter_is_named(values, field):
    with pytest.raises(ValueError, match=f"^{field}: "):
        GravityParams(**values)
