"""Attributes that are measured: sizes beside like things, and colours that are excluded."""

import numpy as np
import pytest

from sceneq_core.encoding.colour import COLOUR_TERMS
from sceneq_core.routing.attribute_fit import log_excluded, log_size

from support.furnished import Thing, snapshot

BOXES = tuple(
    Thing("box", (x, 0.0, 0.0), (x + edge, edge, height))
    for x, edge, height in ((0.0, 0.2, 0.2), (1.0, 0.4, 0.4), (2.0, 0.8, 0.8), (3.0, 0.4, 1.6))
)
SCENE = snapshot(BOXES)
ALIKE = np.zeros(4)


@pytest.mark.parametrize(
    ("word", "first", "last"),
    [("small", 0, 2), ("large", 2, 0), ("tall", 3, 0), ("low", 0, 3), ("long", 2, 0)],
)
def test_sizes_are_measured(word, first, last):
    fit = log_size(SCENE, [word], ALIKE)
    assert (fit.argmax(), fit.argmin()) == (first, last)
    assert (fit < 0).all()


def test_small_and_large_are_opposites_that_add_up_to_one():
    both = np.exp(log_size(SCENE, ["small"], ALIKE)) + np.exp(log_size(SCENE, ["large"], ALIKE))
    assert both == pytest.approx(np.ones(4))


def test_size_is_judged_beside_the_things_that_are_meant():
    """Among the two smallest, the second is the large one; the others do not count."""
    only = np.array([0.0, 0.0, -50.0, -50.0])
    fit = np.exp(log_size(SCENE, ["large"], only))
    assert fit[0] < 0.2
    assert fit[1] > 0.8


def test_things_of_one_size_are_neither_large_nor_small():
    same = snapshot(BOXES[1:2] * 3)
    assert np.exp(log_size(same, ["large"], np.zeros(3))) == pytest.approx(np.full(3, 0.5))


def test_an_excluded_colour_counts_against():
    p = np.full((2, len(COLOUR_TERMS)), 0.01)
    p[0, 3] = 0.9
    fit = np.exp(log_excluded(np.log(p), (3,)))
    assert fit == pytest.approx([0.1, 0.99])
    assert np.exp(log_excluded(np.log(p), ())) == pytest.approx([1.0, 1.0])
