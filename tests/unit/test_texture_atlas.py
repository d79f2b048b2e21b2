import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from sceneq_tools.room.light.texture_atlas import halvings, texture_atlas

FULL = np.array([0], np.int32)


def gradient(height: int, width: int) -> np.ndarray:
    texture = np.zeros((height, width, 4), np.uint8)
    texture[..., 0] = np.arange(width) * 10
    texture[..., 1] = (np.arange(height) * 10)[:, None]
    texture[..., 3] = 255
    return texture


def read(atlas, texture: int, u: float, v: float, level: int = 0) -> np.ndarray:
    at = np.array([[u, v]], np.float32)
    return atlas.read(np.array([texture], np.int32), at, np.array([level], np.int32))[0]


def test_the_first_row_is_at_the_top() -> None:
    atlas = texture_atlas([halvings(gradient(8, 16), 64)])

    assert read(atlas, 0, 0.5 / 16, 1 - 0.5 / 8).tolist() == [0, 0, 0, 255]
    assert read(atlas, 0, 3.5 / 16, 1 - 2.5 / 8).tolist() == [30, 20, 0, 255]


@given(st.integers(-3, 3), st.integers(-3, 3), st.floats(0, 0.99), st.floats(0, 0.99))
def test_a_texture_repeats_in_both_directions(m: int, n: int, u: float, v: float) -> None:
    atlas = texture_atlas([halvings(gradient(8, 16), 64)])

    here, there = read(atlas, 0, u, v).astype(int), read(atlas, 0, u + m, v + n).astype(int)
    assert np.abs(here - there).max() <= 1 or min(u, v) < 1e-3 or max(u, v) > 1 - 1e-3


def test_textures_do_not_bleed_into_each_other() -> None:
    plain = [np.full((h, w, 4), value, np.uint8) for h, w, value in ((8, 8, 10), (5, 9, 200))]
    atlas = texture_atlas([halvings(t, 64) for t in plain])

    for u in np.linspace(0, 1, 23):
        for level in range(5):
            assert read(atlas, 0, u, u, level).tolist() == [10] * 4
            assert read(atlas, 1, u, 1 - u, level).tolist() == [200] * 4


def test_the_last_halving_is_the_mean() -> None:
    texture = np.zeros((16, 16, 4), np.uint8)
    texture[::2] = 200

    assert np.abs(read(texture_atlas([halvings(texture, 64)]), 0, 0.3, 0.3, 99) - 100.0).max() <= 1


def test_a_large_texture_is_shrunk() -> None:
    assert halvings(np.zeros((300, 600, 4), np.uint8), 100)[0].shape == (50, 100, 4)


def test_many_reads_are_the_same_as_one() -> None:
    atlas = texture_atlas([halvings(gradient(8, 16), 64)])
    uv = np.random.default_rng(1).random((1500, 2)).astype(np.float32)
    zeros = np.zeros(1500, np.int32)

    many = atlas.read(zeros, uv, zeros)
    assert np.array_equal(many[1234], read(atlas, 0, *uv[1234]))
