"""Noise of unit variance, and spots that cover a share."""

import numpy as np
import pytest

from sceneq_tools.room.camera.grain import grain, patches

SHAPE = (300, 400)


@pytest.mark.parametrize("size_px", [0.0, 0.6, 1.6, 4.0])
def test_noise_keeps_its_variance_whatever_its_grain(size_px: float) -> None:
    noise = grain(SHAPE, size_px, np.random.default_rng(1))

    assert noise.dtype == np.float32
    assert noise.std() == pytest.approx(1.0, abs=0.05)


def test_channels_have_noise_of_their_own() -> None:
    noise = grain((*SHAPE, 3), 1.0, np.random.default_rng(1)).reshape(-1, 3)

    assert np.abs(np.corrcoef(noise.T) - np.eye(3)).max() < 0.03


def test_neighbours_are_alike() -> None:
    noise = grain(SHAPE, 1.6, np.random.default_rng(1))

    assert (noise[:, 1:] * noise[:, :-1]).mean() == pytest.approx(
        np.exp(-1 / (4 * 1.6**2)), abs=0.05
    )


@pytest.mark.parametrize("share", [0.0, 0.0015, 0.55, 1.0])
def test_spots_cover_their_share(share: float) -> None:
    assert patches(SHAPE, share, np.random.default_rng(2)).mean() == pytest.approx(share, abs=0.02)
