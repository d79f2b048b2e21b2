from dataclasses import replace

import numpy as np
import pytest

from sceneq_tools.room.mesh import Material
from sceneq_tools.room.models.tints import TINTS
from sceneq_tools.room.truth.attributes import attributes, surface_colours
from sceneq_tools.room.truth.colour_names import COLOURS, CONFUSED, colour_index

from support.boxed_room import RED, WHITE, box, placed, thing


@pytest.mark.parametrize("name", TINTS)
def test_every_paint_is_called_by_its_name(name: str) -> None:
    (index,) = colour_index(np.array([TINTS[name]]))
    assert COLOURS[index] == name.replace("gray", "grey")


@pytest.mark.parametrize(
    ("srgb", "name"),
    [
        ((0.02, 0.02, 0.03), "black"),
        ((0.5, 0.5, 0.5), "grey"),
        ((1.0, 1.0, 1.0), "white"),
        ((0.6, 0.35, 0.15), "brown"),
        ((0.85, 0.75, 0.6), "beige"),
        ((0.9, 0.1, 0.6), "pink"),
        ((0.0, 0.0, 0.0), "black"),
    ],
)
def test_common_colours(srgb: tuple[float, float, float], name: str) -> None:
    assert COLOURS[colour_index(np.array([srgb]))[0]] == name


def test_every_colour_may_be_called_by_its_own_name() -> None:
    assert all(name in CONFUSED[name] for name in COLOURS)


def test_the_inside_and_the_bottom_of_a_thing_are_not_seen() -> None:
    outer, inner = box((1.0, 1.0, 1.0), RED), box((0.9, 0.9, 0.9), (0.1, 0.8, 0.1))
    count = len(outer.vertices)
    both = replace(
        outer,
        vertices=np.vstack([outer.vertices, inner.vertices + np.float32([0, 0, 0.05])]),
        normals=np.vstack([outer.normals, inner.normals]),
        uv=np.vstack([outer.uv, inner.uv]),
        faces=np.vstack([outer.faces, inner.faces + count]).astype(np.int32),
        material_index=np.concatenate([outer.material_index, inner.material_index + 1]),
        materials=outer.materials + inner.materials,
    )
    assert surface_colours(both) == (("red", 1.0),)


def test_a_texture_is_read_where_it_is_and_not_where_it_is_cut_out() -> None:
    texture = np.zeros((2, 2, 4), np.uint8)
    texture[0], texture[1] = (0, 0, 255, 255), (255, 0, 0, 0)
    plain = box((1.0, 1.0, 1.0))
    uv = np.where(plain.vertices[:, 2:] > 0.5, 0.99, 0.01) * np.ones((1, 2))
    mesh = replace(plain, uv=uv.astype(np.float32), materials=(Material(WHITE, texture),))
    assert surface_colours(mesh) == (("blue", 1.0),)


def test_a_thing_of_two_colours_has_none() -> None:
    plain = box((1.0, 1.0, 1.0), RED)
    halves = np.arange(12, dtype=np.int32) % 2
    mesh = replace(plain, material_index=halves, materials=(Material(RED), Material(WHITE)))
    found = attributes(replace(thing(9, "cup", "top", (1, 1, 1), placed(0, 0)), mesh=mesh))
    assert found.colour is None
    assert dict(found.colour_shares)["red"] == pytest.approx(0.5, abs=0.05)


def test_paint_that_covers_too_little_is_no_colour() -> None:
    cup = thing(9, "cup", "top", (1, 1, 1), placed(0, 0), colour=WHITE)
    assert attributes(replace(cup, tint="red")).colour is None
    assert attributes(replace(cup, tint="white")).colour == "white"


def test_nobody_names_a_pattern_by_a_colour() -> None:
    assert attributes(thing(9, "cup", "top", (1, 1, 1), placed(0, 0), colour=RED)).colour == "red"
    board = thing(9, "chessboard", "top", (1, 1, 0.1), placed(0, 0), colour=RED)
    assert attributes(board).colour is None


def test_size_is_along_the_own_axes() -> None:
    turned = thing(9, "cup", "top", (2.0, 1.0, 0.5), placed(0, 0, yaw=0.7))
    assert attributes(turned).size_m == (2.0, 1.0, 0.5)
