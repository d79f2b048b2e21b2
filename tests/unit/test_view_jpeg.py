"""JPEG in memory."""

import numpy as np
import pytest

from sceneq_core.views.jpeg import jpeg_from_rgb, jpeg_size, rgb_from_jpeg, with_box

BLUE = np.full((40, 60, 3), (20, 40, 220), np.uint8)


def test_colours_come_back_in_rgb_order():
    assert np.abs(rgb_from_jpeg(jpeg_from_rgb(BLUE)).astype(int) - BLUE).max() <= 4


def test_the_header_tells_the_size():
    assert jpeg_size(jpeg_from_rgb(BLUE)) == (40, 60)


@pytest.mark.parametrize(
    "data", [b"", b"\xff\xd8\xff\xd9", b"nonsense", b"\xff\xd8\xff\xe0\xff\xd9"]
)
def test_what_is_no_jpeg_is_refused(data):
    assert jpeg_size(data) is None
    with pytest.raises(ValueError, match="no JPEG"):
        rgb_from_jpeg(data)


def test_a_box_is_drawn_where_it_is():
    boxed = rgb_from_jpeg(with_box(jpeg_from_rgb(BLUE), np.array([20, 10, 50, 30], np.float32)))
    differs = np.abs(boxed.astype(int) - BLUE).max(axis=2) > 60
    rows, columns = np.nonzero(differs)
    assert abs(int(rows.min()) - 10) <= 3
    assert abs(int(columns.max()) - 49) <= 3
    assert not differs[18:22, 30:40].any()


def test_a_box_beyond_the_image_is_clipped():
    beyond = with_box(jpeg_from_rgb(BLUE), np.array([-1e9, -5, 1e9, 99], np.float32))
    whole = with_box(jpeg_from_rgb(BLUE), np.array([0, 0, 60, 40], np.float32))
    assert beyond == whole
    assert jpeg_size(beyond) == (40, 60)


def test_a_box_must_be_finite():
    with pytest.raises(ValueError, match="not finite"):
        with_box(jpeg_from_rgb(BLUE), np.array([0, 0, np.nan, 9], np.float32))
