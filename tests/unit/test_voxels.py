"""Running means, and free space that clears them."""

import numpy as np
import pytest

from sceneq_core.mapping.free_space import FreeSpaceParams, find_seen_through
from sceneq_core.mapping.surface import SurfaceParams, measure_surface
from sceneq_core.mapping.voxels import Voxels

from support.surfaces import flat_frame, patch, surface

EVERY_PIXEL = SurfaceParams(stride_px=1)
NOTHING = np.zeros(0, np.int32)


def test_a_voxel_holds_the_weighted_mean_of_its_points():
    voxels = Voxels(0.1)
    voxels.integrate(surface([[0.01, 0.02, 0.03]], rgb=(10, 20, 30), weight=1.0))
    touched = voxels.integrate(surface([[0.05, 0.02, 0.03]], rgb=(50, 20, 30), weight=3.0))
    assert touched.voxel_id.tolist() == [0]
    assert touched.new_id.tolist() == []
    assert voxels.points_world(touched.voxel_id) == pytest.approx(np.array([[0.04, 0.02, 0.03]]))
    assert voxels.rgb(touched.voxel_id).tolist() == [[40, 20, 30]]
    assert voxels.normals_world(touched.voxel_id).tolist() == [[0.0, 0.0, -1.0]]


def test_negative_coordinates_round_down():
    voxels = Voxels(0.1)
    touched = voxels.integrate(surface([[-0.01, 0.0, -0.11]]))
    assert voxels.coord(touched.voxel_id).tolist() == [[-1, 0, -2]]


def test_a_cleared_voxel_is_empty_and_starts_anew_under_its_id():
    voxels = Voxels(0.1)
    first = voxels.integrate(surface([[0.05, 0.05, 0.05]])).voxel_id
    voxels.clear(first)
    assert voxels.occupied(first).tolist() == []
    again = voxels.integrate(surface([[0.07, 0.05, 0.05]])).voxel_id
    assert again.tolist() == first.tolist()
    assert voxels.points_world(again)[0, 0] == pytest.approx(0.07)


def test_opposite_normals_cancel_to_zero_not_to_nan():
    voxels = Voxels(0.1)
    voxels.integrate(surface([[0.05, 0.05, 0.05]], normal=(0, 0, 1)))
    touched = voxels.integrate(surface([[0.05, 0.05, 0.05]], normal=(0, 0, -1)))
    assert voxels.normals_world(touched.voxel_id).tolist() == [[0.0, 0.0, 0.0]]


def seen_through(voxels, depth_m, touched=NOTHING):
    return find_seen_through(voxels, touched, flat_frame(depth_m), FreeSpaceParams()).tolist()


def test_what_the_camera_looks_through_is_before_the_surface_it_measures():
    voxels = Voxels(0.02)
    near = voxels.integrate(surface(patch((-0.1, 0.1), (-0.1, 0.1), 1.0))).voxel_id
    wall = voxels.integrate(surface(patch((-0.1, 0.1), (-0.1, 0.1), 2.0))).voxel_id
    assert seen_through(voxels, 2.0) == near.tolist()
    assert seen_through(voxels, 4.0) == sorted([*near.tolist(), *wall.tolist()])


def test_what_was_touched_or_is_empty_is_not_looked_through():
    voxels = Voxels(0.02)
    near = voxels.integrate(surface(patch((-0.1, 0.1), (-0.1, 0.1), 1.0))).voxel_id
    assert seen_through(voxels, 2.0, touched=near[10:]) == near[:10].tolist()
    voxels.clear(near[:5])
    assert seen_through(voxels, 2.0, touched=near[10:]) == near[5:10].tolist()


def test_holes_noise_and_what_is_out_of_view_are_not_looked_through():
    voxels = Voxels(0.02)
    voxels.integrate(surface(patch((-0.1, 0.1), (-0.1, 0.1), 1.0)))
    voxels.integrate(surface(patch((2.0, 2.2), (-0.1, 0.1), 1.0)))
    voxels.integrate(surface(patch((-0.1, 0.1), (-0.1, 0.1), -1.0)))
    assert seen_through(voxels, 0.0) == []
    assert seen_through(voxels, 1.05) == []


def test_points_normals_and_trust_of_a_tilted_plane():
    rows = np.arange(60)[:, None]
    inverse_depth = 0.5 + 0.2 * (rows - 29.5) / 100.0
    frame = flat_frame(1.0 / inverse_depth)
    measured = measure_surface(frame, EVERY_PIXEL)
    inner = (measured.row > 4) & (measured.row < 55)
    normal = -np.array([0.0, 0.2, 0.5]) / np.hypot(0.2, 0.5)
    assert np.abs(measured.normals_world[inner] - normal).max() < 1e-3
    distance = measured.points_world @ normal
    assert np.ptp(distance[inner]) < 2e-3
    assert (measured.weight > 0).all()


def test_flying_pixels_and_far_depth_are_left_out():
    depth = np.full((60, 80), 1.0, np.float32)
    depth[:, 40:] = 2.0
    depth[:, 70:] = 9.0
    depth[:10] = 0.0
    measured = measure_surface(flat_frame(depth), SurfaceParams(stride_px=1, max_depth_m=5.0))
    assert not np.isin(measured.column, (39, 40, 69)).any()
    assert measured.column.max() < 69
    assert measured.row.min() >= 10


def test_an_empty_depth_image_gives_an_empty_surface():
    voxels = Voxels(0.02)
    touched = voxels.integrate(measure_surface(flat_frame(0.0), EVERY_PIXEL))
    assert touched.voxel_id.shape == (0,)
    assert len(voxels) == 0


@pytest.mark.parametrize(
    ("params", "values", "field"),
    [
        (SurfaceParams, {"stride_px": 0}, "stride_px"),
        (SurfaceParams, {"max_depth_m": 0.1}, "max_depth_m"),
        (SurfaceParams, {"normal_radius_px": 0}, "normal_radius_px"),
        (SurfaceParams, {"max_jump_per_m": 0.0}, "max_jump_per_m"),
        (SurfaceParams, {"max_smooth_per_m": -1.0}, "max_smooth_per_m"),
        (SurfaceParams, {"min_cosine": 1.0}, "min_cosine"),
        (FreeSpaceParams, {"margin_m": 0.0}, "margin_m"),
        (FreeSpaceParams, {"noise_per_m": -1.0}, "noise_per_m"),
        (FreeSpaceParams, {"max_depth_m": 0.0}, "max_depth_m"),
    ],
)
def test_a_bad_parameter_is_named(params, values, field):
    with pytest.raises(ValueError, match=f"^{field}: "):
        params(**values)
