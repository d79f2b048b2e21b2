"""Painted textures."""

import numpy as np
import pytest

from sceneq_tools.room.textures import paintings, rugs, textures

MAKERS = {
    "planks": textures.planks,
    "wood": textures.wood,
    "tiles": textures.tiles,
    "plaster": textures.plaster,
    "fabric": textures.fabric,
    "carpet": textures.carpet,
    "sky": textures.sky,
    **{
        f"wallpaper {p}": lambda r, p=p: textures.wallpaper(r, pattern=p)
        for p in textures.WALLPAPERS
    },
    **{f"painting {s}": lambda r, s=s: textures.painting(r, s) for s in paintings.PAINTINGS},
    **{f"rug {s}": lambda r, s=s: textures.rug(r, s) for s in rugs.RUGS},
}


@pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS.keys())
def test_a_seed_decides_the_picture(make):
    first, again, other = (make(np.random.default_rng(seed)) for seed in (5, 5, 6))
    assert first.dtype == np.uint8
    assert first.shape[2] == 4
    assert np.all(first[..., 3] == 255)
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)


def test_unknown_styles_are_refused():
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="no painting 'cubes'"):
        textures.painting(rng, "cubes")
    with pytest.raises(ValueError, match="no rug 'shaggy'"):
        textures.rug(rng, "shaggy")
    with pytest.raises(ValueError, match="no wallpaper 'lions'"):
        textures.wallpaper(rng, pattern="lions")


def test_floors_repeat_without_a_seam():
    planks = textures.planks(np.random.default_rng(1))[..., :3].astype(int)
    across = np.abs(planks[:, 0] - planks[:, -1]).mean()
    inside = np.abs(np.diff(planks, axis=1)).mean()
    assert across < 4 * inside + 4
