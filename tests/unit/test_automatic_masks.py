"""Automatic masks from a network that is a drawing: every filter by hand."""

from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.segmentation.automatic_masks import AutomaticParams, automatic_labels
from sceneq_core.segmentation.letterbox import squashed

SIZE = (64, 64)
BOX = squashed(32, 32, SIZE)
PARAMS = AutomaticParams(points_per_side=4, points_at_once=5, least_px=4)


def logits(left, top, right, bottom, height=8.0):
    """A mask in the coarse map of 16 x 16 cells of 4 pixels of the input."""
    drawn = np.full((16, 16), -height, np.float32)
    drawn[top:bottom, left:right] = height
    return drawn


LEFT, MUG = logits(0, 0, 8, 16), logits(2, 2, 6, 6)
BLURRED = logits(8, 0, 16, 16, height=0.5)
NOTHING = np.full((16, 16), -8.0, np.float32)


class Drawing:
    """On the left half: the half and a mug on it; on the right: an unstable mask."""

    def __init__(self, mug_score=0.9):
        self.mug_score = mug_score
        self.asked = []

    def __call__(self, points):
        self.asked.append(len(points))
        on_left = points[:, 0] < 32
        masks = np.where(on_left[:, None, None], LEFT, BLURRED)
        mugs = np.where(on_left[:, None, None], MUG, NOTHING)
        scores = np.stack([np.full(len(points), 0.95), np.where(on_left, self.mug_score, 0.1)], 1)
        return np.stack([masks, mugs], axis=1), scores.astype(np.float32)


def test_doubles_unstable_and_unsure_masks_go_and_the_mug_lies_on_the_half():
    drawing = Drawing()
    labels = automatic_labels(drawing, BOX, SIZE, PARAMS)
    assert drawing.asked == [5, 5, 5, 1]
    wanted = np.zeros((32, 32), np.uint16)
    wanted[:, :16] = 1
    wanted[4:12, 4:12] = 2
    assert np.array_equal(labels, wanted)


def test_the_least_predicted_iou_is_a_parameter():
    labels = automatic_labels(Drawing(mug_score=0.87), BOX, SIZE, PARAMS)
    assert labels.max() == 1
    lower = replace(PARAMS, iou_min=0.85)
    assert automatic_labels(Drawing(mug_score=0.87), BOX, SIZE, lower).max() == 2


def test_the_least_stability_is_a_parameter():
    labels = automatic_labels(Drawing(), BOX, SIZE, replace(PARAMS, stability_offset=0.25))
    assert (labels[:, 16:] > 0).all()


def test_a_network_that_finds_nothing_gives_an_empty_image():
    labels = automatic_labels(Drawing(), BOX, SIZE, replace(PARAMS, iou_min=0.99))
    assert labels.shape == (32, 32)
    assert not labels.any()


@pytest.mark.parametrize(
    ("name", "value"),
    [("points_per_side", 0), ("iou_min", 1.1), ("nms_iou", -0.1), ("least_px", 0)],
)
def test_bad_parameters_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}:"):
        AutomaticParams(**{name: value})
