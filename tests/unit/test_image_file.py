"""Complete or not: read from the structure of PNG and JPEG files."""

import cv2
import numpy as np
import pytest

from sceneq_nodes._image_file import decode_depth_mm, decode_rgb, header

RGB = np.random.default_rng(0).integers(0, 255, (30, 40, 3), dtype=np.uint8)
DEPTH = np.random.default_rng(1).integers(0, 9000, (30, 40), dtype=np.uint16)


def file(array: np.ndarray, end: str, *options: int) -> bytes:
    return cv2.imencode(end, array, options)[1].tobytes()


@pytest.mark.parametrize(
    ("data", "bits", "channels"),
    [
        (file(RGB, ".png"), 8, 3),
        (file(RGB, ".jpg"), 8, 3),
        (file(RGB, ".jpg", cv2.IMWRITE_JPEG_PROGRESSIVE, 1), 8, 3),
        (file(DEPTH, ".png"), 16, 1),
    ],
)
def test_header_of_a_complete_file(data: bytes, bits: int, channels: int) -> None:
    found = header(data)
    assert (found.size, found.bits, found.channels) == ((40, 30), bits, channels)
    assert found.is_depth == (bits == 16)


@pytest.mark.parametrize("data", [file(RGB, ".png"), file(RGB, ".jpg"), file(DEPTH, ".png")])
def test_a_file_that_was_cut_anywhere_is_refused(data: bytes) -> None:
    for length in range(0, len(data) - 1, 7):
        with pytest.raises(ValueError, match=r"cut off|damaged|empty|neither"):
            header(data[:length])


def test_any_flipped_byte_of_a_png_is_noticed() -> None:
    data = bytearray(file(DEPTH, ".png"))
    for at in range(0, len(data), 11):
        data[at] ^= 0xFF
        with pytest.raises(ValueError, match=r"cut off|damaged|neither"):
            header(bytes(data))
        data[at] ^= 0xFF


def test_decoding() -> None:
    np.testing.assert_array_equal(decode_rgb(file(RGB[..., ::-1], ".png")), RGB)
    np.testing.assert_array_equal(decode_depth_mm(file(DEPTH, ".png")), DEPTH)
    with pytest.raises(ValueError, match="colour does not decode"):
        decode_rgb(b"nothing")
    with pytest.raises(ValueError, match="uint16"):
        decode_depth_mm(file(RGB, ".png"))
