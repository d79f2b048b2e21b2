"""Depth for a thin link is lossless, whatever the sensor says."""

import numpy as np
import pytest
import zstandard
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from sceneq_nodes._depth_codec import compressed_depth, depth_from_planes
from sceneq_nodes._images import array_from_image, image_data
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import ImageData


@given(arrays(np.uint16, array_shapes(min_dims=2, max_dims=2, max_side=20)))
def test_every_depth_comes_back(depth_mm: np.ndarray) -> None:
    planes = zstandard.ZstdDecompressor().decompress(compressed_depth(depth_mm))
    assert np.array_equal(depth_from_planes(planes, depth_mm.shape), depth_mm)


@given(st.integers(0, 2**32 - 1))
def test_noise_costs_less_than_as_plain_bytes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    depth_mm = (2000 + 3 * np.arange(64) + rng.normal(0, 2, (48, 64))).astype(np.uint16)
    plain = zstandard.ZstdCompressor(level=1).compress(depth_mm.tobytes())
    assert len(compressed_depth(depth_mm)) < 0.9 * len(plain)


def test_it_is_a_codec_of_images() -> None:
    depth_mm = np.arange(24 * 40, dtype=np.uint16).reshape(24, 40)[:, ::-1]
    image = image_data(depth_mm, "delta")
    assert (image.codec, image.dtype, image.shape) == ("delta", "<u2", (24, 40))
    assert np.array_equal(array_from_image(image), depth_mm)


def test_it_is_none_for_colour() -> None:
    rgb = np.zeros((4, 4, 3), np.uint8)
    with pytest.raises(ValueError, match="unknown image codec 'delta'"):
        image_data(rgb, "delta")
    data = zstandard.ZstdCompressor().compress(rgb.tobytes())
    with pytest.raises(DecodeError, match="unknown codec"):
        array_from_image(ImageData("delta", "|u1", (4, 4, 3), data))
