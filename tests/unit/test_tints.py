"""Painting of models."""

import numpy as np
import pytest

from sceneq_tools.room.mesh import Material
from sceneq_tools.room.models.finishes import plain
from sceneq_tools.room.models.solids import assembled, standing_box
from sceneq_tools.room.models.tints import TINTS, tinted

GREY, BLACK = plain((0.5, 0.5, 0.5)), plain((0.0, 0.0, 0.0))


def test_the_largest_plain_material_is_painted():
    parts = [
        standing_box(GREY, (1, 1, 1), (0, 0, 0)),
        standing_box(BLACK, (0.1, 0.1, 0.1), (0, 0, 1)),
    ]
    painted = tinted(assembled(parts), "red")
    assert [material.colour for material in painted.materials] == [TINTS["red"], BLACK.colour]


def test_what_has_the_same_colour_is_painted_with_it():
    twin = plain((0.51, 0.5, 0.5))
    parts = [
        standing_box(GREY, (1, 1, 1), (0, 0, 0)),
        standing_box(twin, (0.1, 0.1, 0.1), (0, 0, 1)),
    ]
    assert {m.colour for m in tinted(assembled(parts), "blue").materials} == {TINTS["blue"]}


def test_pictures_and_glass_are_not_painted():
    picture = Material(texture=np.full((2, 2, 4), 255, np.uint8))
    for material in (picture, Material(opacity=0.3)):
        with pytest.raises(ValueError, match="cannot be tinted"):
            tinted(assembled([standing_box(material, (1, 1, 1), (0, 0, 0))]), "red")


def test_a_small_plain_part_is_too_little():
    picture = Material(texture=np.full((2, 2, 4), 255, np.uint8))
    parts = [
        standing_box(picture, (1, 1, 1), (0, 0, 0)),
        standing_box(GREY, (0.1, 0.1, 0.1), (0, 0, 1)),
    ]
    with pytest.raises(ValueError, match="only 1 % of the surface is plain"):
        tinted(assembled(parts), "red")
