"""Intersection over union of regions, by hand."""

import numpy as np
import pytest

from sceneq_core.evaluation.mask_iou import mask_iou


def test_iou_counts_points_that_belong_to_nothing_else():
    true = np.array([1, 1, 1, 2, 2, 0, 0])
    found = np.array([7, 7, 9, 9, 9, 7, 0])
    iou, true_ids, found_ids = mask_iou(true, found)
    assert true_ids.tolist() == [1, 2]
    assert found_ids.tolist() == [7, 9]
    # 1 and 7 share two; together they hold 3 + 3 - 2. The point of 7 outside counts against it.
    assert iou == pytest.approx(np.array([[2 / 4, 1 / 5], [0 / 5, 2 / 3]]))


def test_nothing_meets_nothing():
    none = np.zeros(4, np.int64)
    iou, true_ids, found_ids = mask_iou(none, none)
    assert iou.shape == (0, 0)
    assert len(true_ids) == len(found_ids) == 0
    assert mask_iou(none, np.array([1, 1, 0, 0]))[0].shape == (0, 1)


def test_both_speak_of_the_same_points():
    with pytest.raises(ValueError, match="second"):
        mask_iou(np.zeros(2, np.int64), np.zeros(3, np.int64))
