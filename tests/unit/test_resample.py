"""Resizing, against Pillow where that is installed, and against what must hold in any case."""

import numpy as np
import pytest

from sceneq_core.encoding.resample import resample

KERNELS = ("bilinear", "bicubic")
RNG = np.random.default_rng(3)


def noise(height, width):
    return RNG.integers(0, 256, (height, width, 3), dtype=np.uint8)


@pytest.mark.parametrize("kernel", KERNELS)
@pytest.mark.parametrize(
    ("source", "target"),
    [((50, 39), (56, 56)), ((120, 160), (56, 75)), ((1, 40), (30, 20)), ((37, 3), (40, 61))],
)
def test_it_is_pillow_to_a_rounding(kernel, source, target):
    pillow = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
    rgb = noise(*source)
    method = {"bilinear": pillow.BILINEAR, "bicubic": pillow.BICUBIC}[kernel]
    wanted = np.asarray(pillow.fromarray(rgb).resize(target[::-1], method)).astype(int)
    difference = np.abs(resample(rgb, target, kernel).astype(int) - wanted)
    assert difference.max() <= 1
    assert (difference > 0).mean() < 0.02


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_constant_stays_and_the_same_size_changes_nothing(kernel):
    flat = np.full((9, 14, 3), 77, np.uint8)
    assert (resample(flat, (21, 5), kernel) == 77).all()
    rgb = noise(9, 14)
    assert np.array_equal(resample(rgb, (9, 14), kernel), rgb)


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_window_is_a_piece_of_the_whole(kernel):
    rgb = noise(31, 47)
    whole = resample(rgb, (20, 64), kernel)
    assert np.array_equal(resample(rgb, (20, 64), kernel, (3, 30, 11, 7)), whole[3:14, 30:37])


def test_a_strip_costs_what_its_window_costs():
    strip = noise(1, 600)
    piece = resample(strip, (224, 134_400), "bicubic", (0, 67_088, 224, 224))
    assert piece.shape == (224, 224, 3)
