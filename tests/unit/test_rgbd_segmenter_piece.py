"""Pieces of an image in their windows."""

import numpy as np

from sceneq_core.segmentation.piece import MARGIN_PX, pieces_of, window_of


def two_blobs():
    where = np.zeros((40, 50), bool)
    where[1:5, 2:6] = True
    where[20:30, 30:45] = True
    where[39, 0] = True
    return where


def test_pieces_come_largest_first_without_the_small_ones():
    assert [p.pixels for p in pieces_of(two_blobs(), 2)] == [150, 16]


def test_pieces_drawn_together_are_the_image():
    where = two_blobs()
    assert np.array_equal(sum(p.drawn(where.shape) for p in pieces_of(where, 1)), where)


def test_a_window_has_a_margin_up_to_the_edge_of_the_image():
    where = two_blobs()
    large, small, _ = pieces_of(where, 1)
    assert large.mask.shape == (10 + 2 * MARGIN_PX, 15 + 2 * MARGIN_PX)
    assert small.window == (slice(0, 9), slice(0, 10))
    assert small.mask.shape == (9, 10)


def test_a_piece_of_a_window_moves_to_its_place_in_the_image():
    where = two_blobs()
    large = pieces_of(where, 1)[0]
    hole = large.mask.copy()
    hole[:, : hole.shape[1] // 2] = False
    part = pieces_of(hole, 1)[0].moved(large.window)
    expected = where.copy()
    expected[:, :37] = False
    assert where[:, 37].any()
    assert np.array_equal(part.drawn(where.shape), expected)


def test_the_window_of_a_mask_is_that_of_its_only_piece():
    where = np.zeros((40, 50), bool)
    where[10:12, 20:33] = True
    window = window_of(where)
    assert window == pieces_of(where, 1)[0].window == (slice(6, 16), slice(16, 37))
