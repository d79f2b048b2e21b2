"""Images and frames survive the wire; what is not an image is refused before it costs memory."""

from dataclasses import replace

import numpy as np
import pytest
import zstandard

from sceneq_core.frame import Frame, depth_from_mm
from sceneq_nodes._images import (
    array_from_image,
    frame_from_message,
    frame_message,
    image_data,
)
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import ImageData


def gradient(height: int = 24, width: int = 40) -> np.ndarray:
    """Return a smooth colour image: red grows to the right, green downwards."""
    rgb = np.zeros((height, width, 3), np.uint8)
    rgb[..., 0] = np.linspace(0, 250, width)
    rgb[..., 1] = np.linspace(0, 250, height)[:, None]
    return rgb


@pytest.fixture
def frame() -> Frame:
    depth_mm = np.arange(24 * 40, dtype=np.uint16).reshape(24, 40)
    K = np.array([[50.0, 0, 20], [0, 50, 12], [0, 0, 1]])
    return Frame(7, 123, gradient(), depth_from_mm(depth_mm), K, np.eye(4))


@pytest.mark.parametrize("codec", ["raw", "zstd"])
@pytest.mark.parametrize(
    "array", [gradient(), np.arange(60_000, dtype=np.uint16).reshape(200, 300)]
)
def test_lossless_codecs_give_the_same_pixels(codec, array):
    image = image_data(array, codec)
    assert image.shape == array.shape
    assert np.array_equal(array_from_image(image), array)
    assert array_from_image(image).dtype == array.dtype


def test_jpeg_keeps_colour_in_rgb_order():
    back = array_from_image(image_data(gradient(), "jpeg"))
    assert np.abs(back.astype(int) - gradient()).mean() < 3


def test_big_endian_and_strided_arrays_travel():
    array = np.arange(600, dtype=">u2").reshape(20, 30)[::2, ::3]
    assert np.array_equal(array_from_image(image_data(array, "raw")), array)


@pytest.mark.parametrize(
    ("array", "codec"),
    [
        (np.zeros((4, 4), np.float32), "raw"),
        (np.zeros((4, 4, 4), np.uint8), "raw"),
        (np.zeros((0, 4), np.uint8), "raw"),
        (np.zeros((4, 4), np.uint8), "jpeg"),
        (np.zeros((4, 4), np.uint8), "webp"),
    ],
)
def test_what_no_codec_carries_is_refused(array, codec):
    with pytest.raises(ValueError, match=r"image|JPEG|codec"):
        image_data(array, codec)


def compressed(size: int) -> bytes:
    return zstandard.ZstdCompressor().compress(bytes(size))


@pytest.mark.parametrize(
    ("image", "complaint"),
    [
        (ImageData("raw", "|u1", (4, 4), bytes(15)), "does not match 15 bytes"),
        (ImageData("raw", "<f4", (4, 4), bytes(64)), "dtype '<f4'"),
        (ImageData("raw", "|u1", (2, 2, 2, 2), bytes(16)), "shape"),
        (ImageData("raw", "|u1", (10**9, 10**9), b""), "shape"),
        (ImageData("raw", "<u2", (16_384, 16_384), b""), "limit"),
        (ImageData("png", "|u1", (4, 4), b""), "unknown codec 'png'"),
        (ImageData("zstd", "|u1", (4, 4), b"nonsense"), "not zstd"),
        (ImageData("zstd", "|u1", (4, 4), compressed(10**8)), "zstd holds 100000000 bytes"),
        (ImageData("zstd", "|u1", (4, 4), compressed(16)[:-3]), "zstd"),
        (ImageData("zstd", "|u1", (4, 4), compressed(16) + b"more"), "zstd"),
        (ImageData("jpeg", "|u1", (4, 4, 3), b"\xff\xd8nonsense\xff\xd9"), "JPEG of size None"),
        (ImageData("jpeg", "|u1", (4, 4), b""), "JPEG of size None"),
        (replace(image_data(gradient(), "jpeg"), shape=(24, 41, 3)), "JPEG of size"),
        (replace(image_data(gradient(), "jpeg"), dtype="<u2"), "JPEG of size"),
    ],
)
def test_bad_images_are_decode_errors(image, complaint):
    with pytest.raises(DecodeError, match=complaint):
        array_from_image(image)


def test_a_cut_jpeg_is_a_decode_error():
    image = image_data(gradient(200, 300), "jpeg")
    with pytest.raises(DecodeError, match="JPEG"):
        array_from_image(replace(image, data=image.data[: len(image.data) // 2]))


@pytest.mark.parametrize("depth_codec", ["raw", "zstd", "delta"])
def test_a_frame_survives(frame, depth_codec):
    back = frame_from_message(frame_message(frame, "raw", depth_codec))
    assert (back.seq, back.stamp_ns) == (7, 123)
    assert np.array_equal(back.rgb, frame.rgb)
    assert np.array_equal(back.depth_m, frame.depth_m)
    assert back.depth_m.dtype == np.float32
    assert np.array_equal(back.K, frame.K)


def mirrored() -> np.ndarray:
    return np.diag([1.0, 1.0, -1.0, 1.0])


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"depth_m": np.zeros((24, 41), np.float32)}, r"rgb is \(24, 40\), depth_mm is \(24, 41\)"),
        ({"T_world_camera": np.full((4, 4), np.nan)}, "T_world_camera: not finite"),
        ({"T_world_camera": 2 * np.eye(4)}, "T_world_camera"),
        ({"T_world_camera": mirrored()}, "T_world_camera: not rigid"),
        ({"K": np.zeros((3, 3))}, "Frame.K"),
        ({"K": np.full((3, 3), np.inf)}, "Frame.K"),
    ],
)
def test_bad_frames_are_decode_errors(frame, changes, complaint):
    with pytest.raises(DecodeError, match=complaint):
        frame_from_message(frame_message(replace(frame, **changes), "raw", "raw"))


def test_swapped_images_are_a_decode_error(frame):
    message = frame_message(frame, "raw", "raw")
    with pytest.raises(DecodeError, match=r"Frame\.rgb"):
        frame_from_message(replace(message, rgb=message.depth_mm))
    with pytest.raises(DecodeError, match=r"Frame\.depth_mm"):
        frame_from_message(replace(message, depth_mm=message.rgb))
    broken = replace(message.depth_mm, data=b"")
    with pytest.raises(DecodeError, match=r"Frame\.depth_mm: image: shape"):
        frame_from_message(replace(message, depth_mm=broken))
