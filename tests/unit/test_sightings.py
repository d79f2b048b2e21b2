import numpy as np
import pytest

from sceneq_tools.room.truth.sightings import SeenParams, count_pixels, sightings


def walk(rate_hz: float = 10.0):
    rows = [np.array([0, 500, 0]), np.array([0, 500]), *[np.array([0, 0, 390])] * 10]
    return sightings([row.astype(np.int64) for row in rows], rate_hz, 640 * 480)


def test_frames_and_pixels_are_counted_over_all_frames() -> None:
    seen = walk()
    assert (seen.frames(1), seen.total(1), seen.most(1)) == (2, 1000, 500)
    assert (seen.frames(7), seen.total(7), seen.most(7)) == (0, 0, 0)


def test_many_small_sights_are_not_a_good_one() -> None:
    assert not walk().well(2, 0, SeenParams())
    assert walk().well(2, 0, SeenParams(well_share=1e-3))


@pytest.mark.parametrize(("rate_hz", "well"), [(10.0, True), (30.0, False)])
def test_seen_well_is_a_matter_of_time(rate_hz: float, well: bool) -> None:
    assert walk(rate_hz).well(2, 0, SeenParams(well_share=1e-3)) == well


def test_what_was_seen_before_it_moved_does_not_count() -> None:
    params = SeenParams(well_share=1e-3)
    assert walk().well(2, 4, params)
    assert not walk().well(2, 5, params)


def test_pixels_are_counted_by_id() -> None:
    image = np.array([[0, 3], [3, 3]], np.uint16)
    assert count_pixels(image).tolist() == [1, 0, 0, 3]
