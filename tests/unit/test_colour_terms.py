"""Colours of pixels and colour words."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.encoding.colour import COLOUR_TERMS, PROTOTYPES_RGB, colour_shares, split_colours


def patch(rgb, side=8):
    return np.full((side, side, 3), rgb, np.uint8)


def shares_of(rgb, mask=None):
    image = patch(rgb)
    return colour_shares(image, np.ones(image.shape[:2], bool) if mask is None else mask)


@pytest.mark.parametrize("term", COLOUR_TERMS)
def test_prototypes_have_the_colour_they_stand_for(term):
    for rgb in PROTOTYPES_RGB[term]:
        assert COLOUR_TERMS[int(shares_of(rgb).argmax())] == term


@pytest.mark.parametrize(
    ("rgb", "term"),
    [
        ((160, 10, 20), "red"),
        ((240, 238, 235), "white"),
        ((25, 24, 26), "black"),
        ((105, 70, 40), "brown"),
        ((20, 60, 150), "blue"),
    ],
)
def test_surfaces_get_the_name_people_use(rgb, term):
    assert COLOUR_TERMS[int(shares_of(rgb).argmax())] == term


def test_only_the_mask_counts():
    image = patch((205, 25, 35))
    image[:, :4] = (250, 250, 250)
    mask = np.zeros((8, 8), bool)
    mask[:, 4:] = True
    red = COLOUR_TERMS.index("red")
    assert colour_shares(image, mask)[red] > 0.85
    assert colour_shares(image, ~mask)[red] < 0.01
    assert colour_shares(image, np.ones_like(mask))[red] == pytest.approx(0.5, abs=0.05)


def test_an_empty_mask_counts_as_a_full_one():
    empty = np.zeros((8, 8), bool)
    assert np.array_equal(shares_of((40, 140, 60), empty), shares_of((40, 140, 60)))


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_shares_are_a_distribution(rgb):
    shares = shares_of(rgb)
    assert shares.shape == (11,)
    assert shares.min() >= 0
    assert shares.sum() == pytest.approx(1, abs=1e-4)


@pytest.mark.parametrize(
    ("text", "rest", "colours"),
    [
        ("red mug", "mug", {"red": 1.0}),
        ("dark blue chair", "chair", {"blue": 1.0}),
        ("Gray and white RUG", "and rug", {"grey": 0.5, "white": 0.5}),
        ("wooden cabinet", "cabinet", {"brown": 1.0}),
        ("light bulb", "light bulb", {}),
        ("greenhouse", "greenhouse", {}),
        ("black", "", {"black": 1.0}),
        ("", "", {}),
    ],
)
def test_colour_words_are_taken_out(text, rest, colours):
    found, shares = split_colours(text)
    assert found == rest
    assert {COLOUR_TERMS[i]: float(shares[i]) for i in np.flatnonzero(shares)} == colours


@given(st.text(max_size=60))
def test_any_text_is_split_without_complaint(text):
    _, shares = split_colours(text)
    assert float(shares.sum()) in (0.0, pytest.approx(1.0, abs=1e-5))
