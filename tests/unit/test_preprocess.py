"""How pictures are prepared for towers, against transformers' own processors."""

import numpy as np
import pytest

from sceneq_core.encoding.preprocess import PatchPreprocess, Preprocess

MEAN, STD = (0.48145466, 0.4578275, 0.40821073), (0.26862954, 0.26130258, 0.27577711)
HALF = (0.5, 0.5, 0.5)
SIZES = [(50, 39), (39, 50), (120, 160), (17, 200), (37, 3), (57, 56)]
LEVEL = 1 / 255
"""A rounding of 8 bits, in the numbers before they are divided by the spread."""


def picture(height, width):
    y, x = np.mgrid[:height, :width]
    waves = [127 + 90 * np.sin(x / 7 + k) * np.cos(y / 9 - k) for k in range(3)]
    return np.stack(waves, axis=-1).astype(np.uint8)


@pytest.mark.parametrize("size", SIZES)
def test_crop_is_what_clip_is_fed(size):
    transformers = pytest.importorskip("transformers", reason="transformers is not installed")
    processor = transformers.CLIPImageProcessorPil(
        size={"shortest_edge": 56}, crop_size={"height": 56, "width": 56}
    )
    wanted = processor(picture(*size), return_tensors="np")["pixel_values"][0]
    got = Preprocess(56, 56, MEAN, STD)(picture(*size))
    assert got.dtype == np.float32
    assert np.abs(got - wanted).max() < 1.01 * LEVEL / min(STD)


@pytest.mark.parametrize("size", SIZES[:3])
def test_squash_is_what_siglip_is_fed(size):
    transformers = pytest.importorskip("transformers", reason="transformers is not installed")
    processor = transformers.SiglipImageProcessorPil(size={"height": 56, "width": 56})
    wanted = processor(picture(*size), return_tensors="np")["pixel_values"][0]
    got = Preprocess(56, 56, HALF, HALF, fit="squash")(picture(*size))
    assert np.abs(got - wanted).max() < 1.01 * LEVEL / 0.5


@pytest.mark.parametrize("size", SIZES)
def test_patches_are_what_siglip_2_is_fed(size):
    transformers = pytest.importorskip("transformers", reason="transformers is not installed")
    processor = transformers.Siglip2ImageProcessorPil(patch_size=8, max_num_patches=20)
    wanted = processor(picture(*size), return_tensors="np")
    got = PatchPreprocess(8, 20, HALF, HALF)(picture(*size))
    assert (got.rows, got.columns) == tuple(wanted["spatial_shapes"][0])
    assert np.abs(got.values - wanted["pixel_values"][0]).max() < 1.01 * LEVEL / 0.5


def test_pad_keeps_the_whole_picture_in_the_middle():
    prepare = Preprocess(20, 20, (0.0,) * 3, (1.0,) * 3, fit="pad", fill=255)
    got = prepare(np.zeros((10, 20, 3), np.uint8))
    assert got.shape == (3, 20, 20)
    assert (got[:, 5:15] == 0).all()
    assert (got[:, :5] == 1).all()
    assert (got[:, 15:] == 1).all()


def test_a_larger_edge_than_the_crop_cuts_more_off():
    rgb = np.zeros((40, 40, 3), np.uint8)
    rgb[10:30, 10:30] = 255
    got = Preprocess(20, 20, (0.0,) * 3, (1.0,) * 3, edge_px=40)(rgb)
    assert (got == 1).all()


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("height_px", {"height_px": 0}),
        ("std", {"std": (0.0, 1.0, 1.0)}),
        ("edge_px", {"edge_px": 10}),
        ("fill", {"fill": 256}),
    ],
)
def test_bad_parameters_are_named(name, changes):
    with pytest.raises(ValueError, match=f"^{name}:"):
        Preprocess(**{"height_px": 20, "width_px": 20, "mean": HALF, "std": HALF} | changes)
