"""Descriptors of view sets: what they depend on, and what not."""

import numpy as np
import pytest

from sceneq_core.encoding.describe import DescribeParams, Describer
from sceneq_core.encoding.hash import HashEncoder, HashParams
from sceneq_core.views.view import View, ViewSet

COLOURS = {0: (205, 25, 35), 1: (40, 140, 60), 2: (30, 85, 190)}


class CountingEncoder(HashEncoder):
    def __init__(self):
        super().__init__(HashParams())
        self.crops = 0

    def encode_crops(self, crops):
        self.crops += len(crops)
        return super().encode_crops(crops)


def view(seq, x=8):
    return View(seq, seq * 10, 64, np.array([x, 8, x + 16, 24], np.float32), np.ones((8, 8), bool))


def image(view):
    return np.full((48, 64, 3), COLOURS[view.seq], np.uint8)


def described(views, encoder=None, **params):
    describer = Describer(encoder or CountingEncoder(), DescribeParams(**params))
    return describer.describe(ViewSet(7, tuple(views)), image)


def test_the_descriptor_is_the_mean_of_the_views():
    result = described([view(0), view(1)])
    reds, greens = (described([view(seq)]).descriptor for seq in (0, 1))
    assert result.descriptor @ reds == pytest.approx(result.descriptor @ greens, abs=0.02)
    assert np.linalg.norm(result.descriptor) == pytest.approx(1)
    assert np.linalg.norm(result.feature) == pytest.approx(1)
    assert result.view_seq == (0, 1)


def test_neither_order_nor_history_changes_a_bit():
    direct = described([view(2), view(0), view(1)]).descriptor
    turned = described([view(1), view(2), view(0)]).descriptor
    describer = Describer(CountingEncoder(), DescribeParams(remembered=2))
    for views in ([view(0)], [view(1, x=20)], [view(0), view(1)], [view(0), view(1), view(2)]):
        last = describer.describe(ViewSet(7, tuple(views)), image)
    assert direct.tobytes() == turned.tobytes() == last.descriptor.tobytes()


def test_views_that_stay_are_not_encoded_again():
    encoder = CountingEncoder()
    describer = Describer(encoder, DescribeParams(levels=3))
    describer.describe(ViewSet(7, (view(0), view(1))), image)
    assert encoder.crops == 6
    describer.describe(ViewSet(7, (view(0), view(1), view(2))), image)
    assert encoder.crops == 9
    describer.describe(ViewSet(7, (view(0, x=9),)), image)
    assert encoder.crops == 12


def test_memory_is_bounded():
    encoder = CountingEncoder()
    describer = Describer(encoder, DescribeParams(levels=1, remembered=1))
    for seq in (0, 1, 0):
        describer.describe(ViewSet(7, (view(seq),)), image)
    assert encoder.crops == 3


def test_views_without_image_are_left_out():
    describer = Describer(CountingEncoder(), DescribeParams())
    only_red = lambda view: image(view) if view.seq == 0 else None  # noqa: E731
    assert describer.describe(ViewSet(7, (view(0), view(1))), only_red).view_seq == (0,)
    assert describer.describe(ViewSet(7, (view(1),)), only_red) is None
    assert describer.describe(ViewSet(7, ()), only_red) is None


@pytest.mark.parametrize(
    ("name", "value"), [("levels", 0), ("levels", 9), ("expand", -0.1), ("remembered", 0)]
)
def test_bad_parameters_are_named(name, value):
    with pytest.raises(ValueError, match=f"^{name}:"):
        DescribeParams(**{name: value})
