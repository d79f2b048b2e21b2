"""Grids, stability, boxes, suppression, specks, letterboxes and label images, by hand."""

import numpy as np
import pytest

from sceneq_core.segmentation.label_image import compact, label_image
from sceneq_core.segmentation.letterbox import fitted, squashed
from sceneq_core.segmentation.mask_filter import (
    box_iou,
    mask_boxes,
    stability,
    suppress,
    without_specks,
)
from sceneq_core.segmentation.point_grid import point_grid


def rectangle(shape, left, top, right, bottom):
    mask = np.zeros(shape, bool)
    mask[top:bottom, left:right] = True
    return mask


def test_points_are_the_middles_of_equal_cells():
    assert point_grid(2, 40, 80).tolist() == [[20, 10], [60, 10], [20, 30], [60, 30]]


def test_stability_is_the_share_that_stays():
    ramp = np.linspace(-2.25, 2.25, 10)[None].repeat(4, axis=0)
    hard = np.where(rectangle((4, 10), 5, 0, 10, 4), 9.0, -9.0)
    got = stability(np.stack([ramp, hard, np.full((4, 10), -9.0)]).astype(np.float32), 1.0)
    assert got.tolist() == pytest.approx([3 / 7, 1.0, 0.0])


def test_boxes_end_one_past_the_mask():
    masks = np.stack([rectangle((6, 8), 2, 1, 5, 6), np.zeros((6, 8), bool)])
    assert mask_boxes(masks).tolist() == [[2, 1, 5, 6], [0, 0, 0, 0]]


def test_overlap_of_boxes():
    boxes = np.array([[0, 0, 4, 4], [2, 0, 6, 4], [4, 0, 8, 4], [1, 1, 1, 1]], np.float32)
    assert box_iou(boxes[0], boxes).tolist() == pytest.approx([1, 1 / 3, 0, 0])


def test_of_boxes_that_overlap_the_best_stays_and_of_equals_the_first():
    boxes = np.array([[0, 0, 10, 10], [0, 0, 10, 9], [20, 0, 30, 10], [20, 0, 30, 10]], np.float32)
    kept = suppress(boxes, np.array([0.5, 0.9, 0.7, 0.7], np.float32), 0.7)
    assert kept.tolist() == [1, 2]
    assert suppress(boxes[:0], np.zeros(0, np.float32), 0.7).tolist() == []


def test_specks_and_holes_go_and_the_largest_island_stays():
    mask = rectangle((20, 20), 2, 2, 12, 12)
    mask[5, 5] = False
    mask[17, 17] = True
    clean = without_specks(mask, 10)
    assert np.array_equal(clean, rectangle((20, 20), 2, 2, 12, 12))
    small = rectangle((20, 20), 4, 4, 6, 6)
    assert np.array_equal(without_specks(small, 10), small)
    assert not without_specks(np.zeros((20, 20), bool), 10).any()


def test_smaller_masks_lie_over_larger_ones():
    table, mug = rectangle((6, 6), 0, 0, 6, 4), rectangle((6, 6), 1, 1, 3, 3)
    labels = label_image([mug, table], (6, 6))
    assert labels.dtype == np.uint16
    assert (labels[mug] == 2).all()
    assert (labels[table & ~mug] == 1).all()
    assert (labels[~table] == 0).all()


def test_what_is_left_of_a_mask_in_a_few_pixels_is_no_segment():
    large, small = rectangle((6, 6), 0, 0, 3, 6), rectangle((6, 6), 0, 0, 3, 5)
    labels = label_image([large, small], (6, 6), least_px=4)
    assert np.unique(labels).tolist() == [0, 1]
    assert (labels == 1).sum() == 15


def test_labels_count_from_one_without_gaps():
    given = np.array([[0, 7, 7], [300, 300, 9]], np.uint16)
    assert compact(given, 2).tolist() == [[0, 1, 1], [2, 2, 0]]


@pytest.mark.parametrize("centred", [True, False])
@pytest.mark.parametrize("size", [(48, 64), (61, 97), (3, 5), (97, 61), (1, 1)])
def test_a_map_comes_back_where_the_picture_was(size, centred):
    box = fitted(*size, (64, 64), centred=centred)
    rgb = np.zeros((*size, 3), np.uint8)
    rgb[: size[0] // 2 + 1, : size[1] // 2 + 1] = 200
    placed = box.placed(rgb, (64, 64), 114)[:, :, 0]
    back = box.restored(placed.astype(np.float32), (64, 64))
    assert back.shape == size
    assert ((back > 100) != (rgb[:, :, 0] > 100)).mean() <= 0.03
    nearest = box.restored(placed, (64, 64), nearest=True)
    assert nearest.dtype == np.uint8
    assert ((nearest > 100) != (rgb[:, :, 0] > 100)).mean() <= 0.03


def test_a_coarse_map_is_placed_by_pixel_middles():
    coarse = np.zeros((4, 4), np.float32)
    coarse[:, 2:] = 1
    back = squashed(8, 16, (64, 64)).restored(coarse, (64, 64))
    assert back[0].tolist() == [0] * 6 + [0.125, 0.375, 0.625, 0.875] + [1] * 6


def test_points_go_where_their_pixels_go():
    box = fitted(30, 60, (64, 64), centred=True)
    assert (box.inner_height, box.inner_width, box.top, box.left) == (32, 64, 16, 0)
    points = box.points(np.array([[0, 0], [60, 30]], np.float32))
    assert points.tolist() == [[0, 16], [64, 48]]
