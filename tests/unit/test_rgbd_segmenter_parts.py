"""The parts of the rgbd segmenter, each on the smallest input that shows what it does."""

import numpy as np
import pytest

from sceneq_core.frame import Frame
from sceneq_core.segmentation.graph_segments import graph_segments
from sceneq_core.segmentation.plane import Plane, fitted_plane
from sceneq_core.segmentation.surface import surface_of
from sceneq_core.segmentation.working_image import WorkingImage, enlarged, reduced

K = np.array([[100.0, 0, 31.5], [0, 100.0, 23.5], [0, 0, 1]])
NOISE = 0.0014


def frame_of(depth_m):
    rgb = np.zeros((*depth_m.shape, 3), np.uint8)
    return Frame(1, 1, rgb, depth_m.astype(np.float32), K, np.eye(4))


def working(closeness):
    colour = np.zeros((*closeness.shape, 3), np.float32)
    return WorkingImage(colour, closeness.astype(np.float32), K, 1)


def test_reduced_depth_is_a_measurement_and_not_a_mean():
    depth_m = np.full((4, 4), 4.0)
    depth_m[:, 1::2] = 1.0
    depth_m[0, 0] = 0
    image = reduced(frame_of(depth_m), width=2)
    assert set(np.unique(image.closeness)) <= {np.float32(0.25), np.float32(1.0)}


def test_reduced_keeps_a_lone_measurement_and_loses_none_where_nothing_is():
    depth_m = np.zeros((4, 4))
    depth_m[3, 3] = 2.0
    assert reduced(frame_of(depth_m), width=2).closeness.tolist() == [[0, 0], [0, 0.5]]


@pytest.mark.parametrize("step", [1, 2, 3, 4])
def test_reduced_depth_is_the_middle_of_what_was_measured(step):
    rng = np.random.default_rng(step)
    depth_m = rng.uniform(1, 3, (4 * step, 5 * step)).astype(np.float32)
    depth_m[rng.random(depth_m.shape) < 0.4] = 0
    closeness = reduced(frame_of(depth_m), width=5).closeness
    for v, u in np.ndindex(4, 5):
        block = depth_m[v * step : (v + 1) * step, u * step : (u + 1) * step]
        measured = np.sort(block[block > 0])
        middle = 1 / measured[len(measured) // 2] if len(measured) else 0
        assert closeness[v, u] == pytest.approx(middle)


def test_reduced_camera_sees_the_same_rays():
    image = reduced(frame_of(np.ones((48, 64))), width=32)
    centre_of_first_block = (0.5 - K[0, 2]) / K[0, 0]
    assert (0 - image.K[0, 2]) / image.K[0, 0] == pytest.approx(centre_of_first_block)


@pytest.mark.parametrize("shape", [(5, 7), (6, 9), (48, 64)])
def test_enlarged_undoes_the_reduction(shape):
    image = reduced(frame_of(np.ones(shape)), width=3)
    labels = np.arange(image.closeness.size).reshape(image.closeness.shape)
    full = enlarged(labels, image.step, shape)
    assert full.shape == shape
    assert full[0, 0] == 0
    assert full[-1, -1] == labels[-1, -1]


def test_graph_segments_part_two_colours_and_ignore_weak_noise():
    colour = np.zeros((20, 30, 3), np.float32)
    colour[:, 12:] = 25
    colour += np.random.default_rng(1).normal(0, 0.2, colour.shape).astype(np.float32)
    regions = graph_segments(colour, np.zeros((20, 30), np.int32), 40, 10)
    assert len(np.unique(regions)) == 2
    assert len(np.unique(regions[:, :12])) == 1


def test_graph_segments_never_cross_a_domain():
    colour = np.zeros((6, 6, 3), np.float32)
    domain = np.zeros((6, 6), np.int32)
    domain[:, 3:] = 1
    domain[2, 2] = -1
    regions = graph_segments(colour, domain, 40, 1)
    assert np.unique(regions).tolist() == [0, 1, 2]
    assert np.argwhere(regions == 0).tolist() == [[2, 2]]


def test_small_regions_join_a_neighbour():
    colour = np.zeros((12, 12, 3), np.float32)
    colour[5:7, 5:7] = 60
    domain = np.zeros((12, 12), np.int32)
    assert len(np.unique(graph_segments(colour, domain, 1, 1))) == 2
    assert len(np.unique(graph_segments(colour, domain, 1, 5))) == 1


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (9, 1)])
def test_graph_segments_of_hardly_an_image(shape):
    colour = np.zeros((*shape, 3), np.float32)
    regions = graph_segments(colour, np.zeros(shape, np.int32), 40, 3)
    assert regions.tolist() == np.ones(shape).tolist()


def test_a_plane_is_found_under_a_quarter_of_outliers():
    true = Plane(np.array([0.001, 0.004, 0.3]))
    closeness = -true.residual(np.zeros((48, 64), np.float32))
    closeness[:24, :32] += 0.2
    surface = surface_of(working(closeness), NOISE, 25)
    plane, inliers = fitted_plane(surface, np.ones((48, 64), bool), NOISE)
    assert plane.coefficients == pytest.approx(true.coefficients, abs=NOISE)
    assert inliers.mean() == pytest.approx(0.75, abs=0.02)


def test_a_sphere_is_no_plane():
    v, u = np.mgrid[:48, :64]
    closeness = (1 + 0.002 * ((u - 32) ** 2 + (v - 24) ** 2)).astype(np.float32)
    surface = surface_of(working(closeness), NOISE, 25)
    assert fitted_plane(surface, np.ones((48, 64), bool), NOISE) is None


def test_height_over_a_plane_is_in_metres():
    wall = Plane(np.array([0.0, 0.0, 0.5]))
    height_m = wall.height_m(np.full((48, 64), 1 / 1.9, np.float32), K)
    assert height_m == pytest.approx(np.full((48, 64), 0.1), abs=1e-5)


def test_normals_face_the_camera():
    surface = surface_of(working(np.full((48, 64), 0.5)), NOISE, 25)
    assert surface.normals_camera[:, 24, 32] == pytest.approx([0, 0, -1], abs=1e-6)
    assert not surface.steps.any()
    assert not surface.creases.any()


def test_a_window_of_a_surface_has_the_same_plane_in_space():
    true = Plane(np.array([0.001, 0.004, 0.3]))
    closeness = -true.residual(np.zeros((48, 64), np.float32))
    surface = surface_of(working(closeness), NOISE, 25)
    part = surface.inside(np.s_[10:40, 20:64])
    plane, _ = fitted_plane(part, np.ones((30, 44), bool), NOISE)
    assert plane.normal_camera(part.K) == pytest.approx(true.normal_camera(K), abs=1e-3)


def test_a_jump_is_a_step_and_a_steep_floor_is_not():
    closeness = np.full((48, 64), 0.5)
    closeness[:, 32:] = 0.6
    assert surface_of(working(closeness), NOISE, 25).steps[:, 31:33].all()
    floor = 0.2 + 0.02 * np.mgrid[:48, :64][0]
    assert not surface_of(working(floor), NOISE, 25).steps[4:-4].any()


@pytest.mark.parametrize(("sign", "folded"), [(-1, True), (1, False)])
def test_only_inward_folds_are_creases(sign, folded):
    """Depth 2 m in the fold and nearer (an inside corner) or farther (an outside one) beside it."""
    x = (np.mgrid[:48, :64][1] - K[0, 2]) / K[0, 0]
    depth = 2 / (1 - sign * np.abs(x))
    creases = surface_of(working(1 / depth), NOISE, 25).creases
    assert creases[10:-10, 31:33].any() == folded
