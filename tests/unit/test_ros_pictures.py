"""Every encoding of an image, pixel by pixel."""

import struct
import tracemalloc
import zlib

import cv2
import numpy as np
import pytest

from sceneq_nodes.ros.pictures import (
    compressed_depth_mm,
    compressed_rgb,
    image_depth_mm,
    image_rgb,
)
from sceneq_nodes.ros.typestore import WireError, typestore

from support.more_data_sets import rvl
from support.ros_robot import COMPRESSED, IMAGE, Robot

ROBOT = Robot()
STORE = typestore("jazzy")
RED, TEAL = (200, 10, 30), (20, 120, 130)
TWO = np.array([[RED, TEAL]], np.uint8)
"""One row: a red pixel and a teal one."""


def sent(message):
    """What arrives: through the bytes of the wire."""
    return STORE.decode(message.__msgtype__, ROBOT.data(message))


def colour(pixels, encoding, **layout):
    return image_rgb(sent(ROBOT.image(pixels, encoding, **layout))).tolist()


def depth(pixels, encoding, **layout):
    return image_depth_mm(sent(ROBOT.image(pixels, encoding, **layout))).tolist()


ALPHA = np.full((1, 2, 1), 77, np.uint8)


@pytest.mark.parametrize(
    ("encoding", "pixels"),
    [
        ("rgb8", TWO),
        ("bgr8", TWO[..., ::-1]),
        ("8UC3", TWO[..., ::-1]),
        ("rgba8", np.concatenate([TWO, ALPHA], axis=2)),
        ("bgra8", np.concatenate([TWO[..., ::-1], ALPHA], axis=2)),
        ("8UC4", np.concatenate([TWO[..., ::-1], ALPHA], axis=2)),
    ],
)
@pytest.mark.parametrize("padding", [0, 5])
def test_colour_comes_out_as_rgb(encoding, pixels, padding):
    assert colour(pixels, encoding, padding=padding) == [[list(RED), list(TEAL)]]


def test_grey_is_repeated():
    assert colour(np.array([[7, 250]], np.uint8), "mono8") == [[[7] * 3, [250] * 3]]
    wide = np.array([[0x1234, 0xFF00]], np.uint16)
    assert colour(wide, "mono16") == [[[0x12] * 3, [0xFF] * 3]]
    assert colour(wide.astype(">u2"), "mono16") == [[[0x12] * 3, [0xFF] * 3]]


def test_yuv_of_webcams():
    grey = np.array([[[128, 90], [128, 200]]], np.uint8)  # u y v y
    rgb = np.array(colour(grey, "yuv422"))
    assert (rgb == rgb[..., :1]).all()
    assert (np.diff(rgb[0, :, 0]) > 0).all()
    assert colour(grey[..., ::-1], "yuv422_yuy2") == rgb.tolist()


@pytest.mark.parametrize("encoding", ["16UC1", "mono16"])
@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("padding", [0, 3])
def test_depth_in_millimetres(encoding, order, padding):
    pixels = np.array([[0, 1234], [65535, 9]], f"{order}u2")
    assert depth(pixels, encoding, padding=padding) == [[0, 1234], [0, 9]]


@pytest.mark.parametrize("order", ["<", ">"])
def test_depth_in_metres(order):
    pixels = np.array([[1.2344, np.nan, np.inf], [-1.0, 0.0, 70.0]], f"{order}f4")
    assert depth(pixels, "32FC1") == [[1234, 0, 0], [0, 0, 0]]


def test_an_unknown_encoding_is_named():
    with pytest.raises(WireError, match="colour of encoding 'bayer_rggb8'"):
        colour(np.zeros((1, 2), np.uint8), "bayer_rggb8")
    with pytest.raises(WireError, match="depth of encoding 'rgb8'"):
        depth(TWO, "rgb8")


@pytest.mark.parametrize("wrong", [{"step": 5}, {"height": 2}, {"width": 0}, {"data": TWO[0, 0]}])
def test_an_image_with_too_few_bytes_is_refused(wrong):
    message = ROBOT.image(TWO, "rgb8")
    for name, value in wrong.items():
        object.__setattr__(message, name, value)
    with pytest.raises(WireError, match="needs more than"):
        image_rgb(message)


def test_jpeg_and_png_colour():
    plain = np.full((8, 8, 3), RED, np.uint8)
    for kind, tolerance in (("jpg", 4), ("png", 0)):
        data = cv2.imencode(f".{kind}", plain[..., ::-1])[1].tobytes()
        message = sent(ROBOT.compressed(data, f"rgb8; {kind} compressed bgr8"))
        assert np.abs(compressed_rgb(message).astype(int) - plain).max() <= tolerance


def test_a_cut_jpeg_is_refused():
    data = cv2.imencode(".jpg", np.zeros((16, 16, 3), np.uint8))[1].tobytes()
    with pytest.raises(WireError, match="cut off"):
        compressed_rgb(sent(ROBOT.compressed(data[:-20], "jpeg")))


MILLIMETRES = np.array([[0, 500, 65535], [1000, 2345, 60000]], np.uint16)


def png(pixels):
    return cv2.imencode(".png", pixels)[1].tobytes()


def test_compressed_depth_in_millimetres():
    data = struct.pack("<iff", 0, 0.0, 0.0) + png(MILLIMETRES)
    message = sent(ROBOT.compressed(data, "16UC1; compressedDepth png"))
    assert compressed_depth_mm(message).tolist() == [[0, 500, 0], [1000, 2345, 60000]]


def test_compressed_depth_in_metres_is_inverse_and_quantised():
    a, b = 10_000.0, -50.0
    depth_m = np.array([[0.5, 1.0], [2.5, np.nan]], np.float32)
    stored = np.where(np.isfinite(depth_m), a / depth_m + b, 0).astype(np.uint16)
    data = struct.pack("<iff", 0, a, b) + png(stored)
    found = compressed_depth_mm(sent(ROBOT.compressed(data, "32FC1; compressedDepth")))
    assert found[1, 1] == 0
    assert np.abs(found - [[500, 1000], [2500, 0]]).max() <= 1


def test_compressed_depth_with_rvl():
    # One run: two pixels of 0, then 5 (+5) and 3 (-2), each number in groups of three bits.
    words = struct.pack("<I", int("2" + "2" + "A1" + "3" + "000", 16))
    data = struct.pack("<iffii", 0, 0.0, 0.0, 4, 1) + words
    message = sent(ROBOT.compressed(data, "16UC1; compressedDepth rvl"))
    assert compressed_depth_mm(message).tolist() == [[0, 0, 5, 3]]


def rvl_message(depth, size=None, head=(0, 0.0, 0.0), words=None, text="16UC1"):
    """Depth as compressed_depth_image_transport sends it with ``format: rvl``."""
    data = rvl(depth) if words is None else words
    size = size or (depth.shape[1], depth.shape[0])
    data = struct.pack("<iffii", *head, *size) + data
    return sent(ROBOT.compressed(data, f"{text}; compressedDepth rvl"))


def test_compressed_depth_with_rvl_in_metres():
    found = compressed_depth_mm(
        rvl_message(np.array([[0, 10_000, 3950]], np.uint16), head=(0, 1e4, -50.0), text="32FC1")
    )
    assert found.tolist() == [[0, 995, 2500]]


def test_rvl_of_a_camera_comes_back():
    rng = np.random.default_rng(3)
    depth = np.cumsum(rng.integers(-40, 41, (48, 64)), axis=1) + 3000
    depth = np.where(rng.random((48, 64)) < 0.3, 0, depth).astype(np.uint16)
    depth[0, :4] = (0, 65534, 1, 65535)
    expected = np.where(depth == 65535, 0, depth)
    np.testing.assert_array_equal(compressed_depth_mm(rvl_message(depth)), expected)
    whole = rvl(depth)
    for kept in (0, 3, 4, len(whole) // 2, len(whole) - 4):
        with pytest.raises(WireError, match="RVL is cut off"):
            compressed_depth_mm(rvl_message(depth, words=whole[:kept]))


def nibbles(text):
    return struct.pack(
        f"<{len(text) // 8}I", *(int(text[i : i + 8], 16) for i in range(0, len(text), 8))
    )


@pytest.mark.parametrize(
    ("size", "words", "said"),
    [
        ((1 << 14, 1 << 14), b"", "16384 x 16384 pixels, the limit"),
        ((1 << 30, 1 << 30), b"", "pixels, the limit"),
        ((0, 5), b"", "0 x 5 pixels"),
        ((-4, -4), b"", "-4 x -4 pixels"),
        ((4, 1), nibbles("ff0f0000"), "RVL is damaged at pixel 63"),  # a run over the end
        ((4, 1), nibbles("00000000"), "RVL is damaged at pixel 0"),  # runs of nothing
        ((4, 1), nibbles("ffffffff" * 4 + "70000000"), "more than 30 bits"),
        ((2, 1), nibbles("02110000"), "a depth does not fit 16 bits"),  # -1
        ((1, 1), nibbles("018888882" + "0000000"), "a depth does not fit 16 bits"),
        ((8, 1), b"\xff" * (1 << 20), "RVL is cut off"),  # one number without an end
    ],
)
def test_rvl_that_is_a_bomb_or_damaged_is_refused(size, words, said):
    with pytest.raises(WireError, match=said):
        compressed_depth_mm(rvl_message(None, size, words=words))


def test_a_long_tail_of_rvl_is_not_read():
    tracemalloc.start()
    try:
        message = rvl_message(np.array([[7, 0, 9]], np.uint16))
        message.data = np.concatenate([message.data, np.full(1 << 22, 0x11, np.uint8)])
        assert compressed_depth_mm(message).tolist() == [[7, 0, 9]]
        assert tracemalloc.get_traced_memory()[1] < 5 * (1 << 22)  # the message, and copies of it
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("text", ["16UC1; compressedDepth png", "16UC1; png"])
def test_a_png_of_depth_is_whole_and_of_a_size_that_can_be(text):
    head = struct.pack("<iff", 0, 0.0, 0.0) if "compressedDepth" in text else b""
    whole = png(np.arange(4096, dtype=np.uint16).reshape(64, 64))
    with pytest.raises(WireError, match="cut off"):
        compressed_depth_mm(sent(ROBOT.compressed(head + whole[:-300], text)))
    chunk = b"IHDR" + struct.pack(">II", 1 << 15, 1 << 15) + whole[24:29]
    large = whole[:12] + chunk + struct.pack(">I", zlib.crc32(chunk)) + whole[33:]
    with pytest.raises(WireError, match="32768 x 32768 pixels, the limit"):
        compressed_depth_mm(sent(ROBOT.compressed(head + large, text)))


def test_plain_png_depth():
    message = sent(ROBOT.compressed(png(MILLIMETRES), "16UC1; png compressed"))
    assert compressed_depth_mm(message)[1].tolist() == [1000, 2345, 60000]


@pytest.mark.parametrize("data", [b"", b"short", struct.pack("<iff", 0, 0, 0) + b"no png"])
def test_damaged_depth_is_refused(data):
    for text in ("16UC1; compressedDepth png", "16UC1; compressedDepth rvl", "16UC1; png"):
        with pytest.raises(WireError):
            compressed_depth_mm(ROBOT.compressed(data, text))


@pytest.mark.parametrize("kind", [IMAGE, COMPRESSED])
def test_bytes_that_are_no_message_are_refused(kind):
    whole = ROBOT.data(
        ROBOT.image(TWO, "rgb8") if kind == IMAGE else ROBOT.compressed(b"abc", "png")
    )
    for data in (b"", b"\0\1", whole[:20], whole[: len(whole) - 2], b"\xff" * 64):
        with pytest.raises(WireError, match=r"bytes are no sensor_msgs/msg/"):
            STORE.decode(kind, data)
    with pytest.raises(WireError, match="unknown message type"):
        STORE.decode("x/msg/Y", whole)
