"""Boxes that grow, and the masks that go with them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.encoding.pyramid import expanded, full_mask, pyramid
from sceneq_core.views.view import View

SIZE = (48, 64)
RGB = np.arange(48 * 64 * 3, dtype=np.uint32).reshape(48, 64, 3).astype(np.uint8)


def view(box, mask):
    return View(3, 30, int(mask.sum()) * 4, np.array(box, np.float32), mask)


def test_levels_grow_by_a_fifth_of_the_edge():
    box = np.array([20, 10, 40, 30], np.float32)
    assert expanded(box, 0.0, SIZE) == (20, 10, 40, 30)
    assert expanded(box, 0.2, SIZE) == (18, 8, 42, 32)
    assert expanded(box, 0.4, SIZE) == (16, 6, 44, 34)


def test_the_image_cuts_boxes_off():
    assert expanded(np.array([-5, 40, 8, 60], np.float32), 0.2, SIZE) == (0, 38, 10, 48)


boxes = st.lists(st.floats(-100, 200, width=32), min_size=4, max_size=4)


@given(boxes, st.floats(0, 2))
def test_every_crop_lies_in_the_image_and_has_a_pixel(edges, ratio):
    x0, x1 = sorted(edges[:2])
    y0, y1 = sorted(edges[2:])
    left, top, right, bottom = expanded(np.array([x0, y0, x1, y1], np.float32), ratio, SIZE)
    assert 0 <= left < right <= SIZE[1]
    assert 0 <= top < bottom <= SIZE[0]


def test_the_half_resolution_mask_returns_to_its_place():
    mask = np.zeros((5, 10), bool)
    mask[:, :5] = True
    whole = full_mask(view((20, 10, 40, 20), mask), SIZE)
    expected = np.zeros(SIZE, bool)
    expected[10:20, 20:30] = True
    assert np.array_equal(whole, expected)


def test_crops_carry_pixels_and_mask_of_the_same_place():
    mask = np.ones((5, 10), bool)
    crops = pyramid(RGB, view((20, 10, 40, 20), mask), levels=3, expand=0.2)
    assert [crop.rgb.shape for crop in crops] == [(10, 20, 3), (12, 24, 3), (14, 28, 3)]
    assert [crop.mask.shape for crop in crops] == [(10, 20), (12, 24), (14, 28)]
    assert [int(crop.mask.sum()) for crop in crops] == [200, 200, 200]
    assert np.array_equal(crops[1].rgb, RGB[9:21, 18:42])
    assert not crops[1].mask[0].any()


@pytest.mark.parametrize("mask", [np.zeros((0, 0), bool), np.zeros((1, 1), bool)])
def test_a_view_without_mask_gives_crops_without_mask(mask):
    crops = pyramid(RGB, view((5, 5, 6, 6), mask), levels=2, expand=0.2)
    assert not any(crop.mask.any() for crop in crops)
