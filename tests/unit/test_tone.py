import numpy as np
import pytest

from sceneq_tools.room.light.tone import auto_exposure, tone_mapped


def test_more_light_is_never_darker_and_nothing_is_black() -> None:
    light = np.linspace(0, 50, 3000, dtype=np.float32)
    steps = tone_mapped(light, 1.0).astype(int)

    assert steps[0] == 0
    assert (np.diff(steps) >= 0).all()
    assert steps[-1] >= 250


def test_a_grey_room_is_mid_grey_at_any_brightness() -> None:
    for brightness in (0.01, 1.0, 300.0):
        radiance = np.full((10, 3), brightness, np.float32)
        assert auto_exposure(radiance) * brightness == pytest.approx(0.2)


def test_a_dark_room_has_an_exposure_too() -> None:
    assert auto_exposure(np.zeros((4, 3), np.float32)) == 1.0
