"""Where things can stand on a model, in it and under it."""

import numpy as np
import pytest

from sceneq_tools.room.layout.supports import supports, underneath
from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.models.solids import assembled, box

WOOD = Material((0.6, 0.4, 0.3))


def table() -> Mesh:
    legs = [box(WOOD, (0.05, 0.05, 0.7), (x, y, 0.35)) for x in (-0.5, 0.5) for y in (-0.3, 0.3)]
    return assembled([box(WOOD, (1.2, 0.8, 0.04), (0, 0, 0.72)), *legs])


def shelf(*, closed: bool = False) -> Mesh:
    boards = [box(WOOD, (0.8, 0.3, 0.02), (0, 0, z)) for z in (0.1, 0.5, 0.9, 1.3)]
    sides = [box(WOOD, (0.02, 0.3, 1.31), (x, 0, 0.655)) for x in (-0.41, 0.41)]
    back = box(WOOD, (0.84, 0.02, 1.31), (0, 0.16, 0.655))
    door = [box(WOOD, (0.84, 0.02, 1.31), (0, -0.16, 0.655))] if closed else []
    return assembled([*boards, *sides, back, *door])


def test_a_table_carries_on_its_top_only() -> None:
    (top,) = supports(table())
    assert top.z == pytest.approx(0.74, abs=0.002)
    assert top.area_m2 == pytest.approx(1.2 * 0.8, rel=0.02)
    assert not top.covered
    assert not top.sunken
    assert np.isinf(top.clearance[np.isfinite(top.height)]).all()


def test_an_open_shelf_has_a_level_for_every_board() -> None:
    levels = supports(shelf())
    assert [level.z for level in levels] == pytest.approx([1.31, 0.91, 0.51, 0.11], abs=0.002)
    assert [level.covered for level in levels] == [False, True, True, True]
    inner = levels[1]
    assert np.nanmax(inner.clearance[np.isfinite(inner.height)]) == pytest.approx(0.38, abs=0.002)


def test_behind_a_door_nothing_is_reached() -> None:
    (top,) = supports(shelf(closed=True))
    assert top.z == pytest.approx(1.31, abs=0.002)


def test_a_slope_carries_nothing() -> None:
    assert supports(assembled([box(WOOD, (1.0, 1.0, 0.02), (0, 0, 0.5)).turned("x", 30)])) == ()


def test_the_floor_below_a_table_is_free_up_to_its_top() -> None:
    below = underneath(table())
    assert below is not None
    free = np.isfinite(below.height)
    assert below.z == 0.0
    assert np.median(below.clearance[free]) == pytest.approx(0.70, abs=0.002)
    assert below.area_m2 < 1.2 * 0.8


def test_nothing_fits_under_a_chest() -> None:
    assert underneath(assembled([box(WOOD, (1.0, 0.5, 0.8), (0, 0, 0.4))])) is None


def test_supports_are_found_once_per_model() -> None:
    model = table()
    assert supports(model) is supports(model)
