"""Exact depth and ids, shadows, glass, cut-outs, edits, and the same bytes twice."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from sceneq_core.ingest.source import Camera
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.light.renderer import Renderer
from sceneq_tools.room.mesh import Material

from support.tiny_room import CAMERA, QUICK, cube, joined, looking, sheet, thing, tiny_room

AHEAD = looking((1.5, 0.5, 1.2), (1.5, 3.0, 1.2))
DOWN = looking((1.5, 0.2, 2.2), (1.5, 1.6, 0.0))


@pytest.fixture(scope="module")
def empty() -> Renderer:
    return Renderer(tiny_room(), QUICK)


@pytest.fixture(scope="module")
def with_cube() -> Renderer:
    return Renderer(tiny_room(thing(20, cube(0.5), (1.5, 1.8, 0.0))), QUICK)


def test_depth_of_a_wall_is_its_distance_along_the_axis(empty: Renderer) -> None:
    rendering = empty.render(AHEAD, CAMERA)

    wall = rendering.instance_id == 4
    assert wall.mean() > 0.4
    np.testing.assert_allclose(rendering.depth_m[wall], 2.5, atol=2e-6)
    assert set(np.unique(rendering.instance_id)) <= {1, 2, 4, 5, 6}
    assert rendering.incidence[60, 80] == pytest.approx(1.0, abs=1e-4)


def test_ids_are_those_at_pixel_centres() -> None:
    room = tiny_room(thing(9, sheet((1.0, 2.0, 0.7), (1.0, 0, 0), (0, 0, 1.0))))
    rendering = Renderer(room, QUICK).render(AHEAD, CAMERA)

    x, y = np.meshgrid(np.arange(160), np.arange(120))
    inside = (np.abs(x - 79.5) * 1.5 / 100 < 0.5) & (np.abs(y - 59.5) * 1.5 / 100 < 0.5)
    assert np.array_equal(rendering.instance_id == 9, inside)


def test_any_camera_sees_the_same_point(empty: Renderer) -> None:
    wide = Camera(np.array([[50.0, 0, 20], [0, 60.0, 10], [0, 0, 1]]), (64, 48))
    rendering = empty.render(AHEAD, wide)

    assert rendering.rgb.shape == (48, 64, 3)
    assert rendering.depth_m[10, 20] == pytest.approx(2.5, abs=1e-5)


def test_a_cube_throws_a_soft_shadow(empty: Renderer, with_cube: Renderer) -> None:
    before = empty.render(DOWN, CAMERA).rgb[..., 1].astype(float) / empty.exposure
    after = with_cube.render(DOWN, CAMERA)

    floor = (after.instance_id == 1) & (after.depth_m > 0)
    ratio = after.rgb[..., 1].astype(float) / with_cube.exposure / np.maximum(before, 1)
    assert ratio[floor].min() < 0.8 * np.median(ratio[floor])


def test_it_is_neither_black_nor_washed_out(with_cube: Renderer) -> None:
    picture = with_cube.render(AHEAD, CAMERA).rgb

    assert 60 < np.median(picture) < 220
    assert (picture == 0).mean() < 0.01


def test_a_room_twice_as_bright_looks_the_same() -> None:
    dim, bright = (
        Renderer(tiny_room(radiance=r), QUICK).render(AHEAD, CAMERA).rgb for r in (1.0, 2.0)
    )

    assert np.abs(dim.astype(int) - bright.astype(int)).max() <= 1


def test_equal_rooms_give_equal_bytes_from_any_thread(with_cube: Renderer) -> None:
    again = Renderer(with_cube.room, replace(QUICK, threads=1))
    with ThreadPoolExecutor(3) as pool:
        several = list(pool.map(lambda _: with_cube.render(DOWN, CAMERA), range(6)))

    expected = again.render(DOWN, CAMERA)
    for rendering in several:
        assert np.array_equal(rendering.rgb, expected.rgb)
        assert np.array_equal(rendering.depth_m, expected.depth_m)


def test_after_an_edit_it_looks_like_a_fresh_renderer() -> None:
    box = cube(0.4)
    before = tiny_room(thing(20, box, (1.0, 1.8, 0.0)), thing(21, box, (2.2, 2.2, 0.0)))
    moved = tiny_room(thing(20, box, (1.8, 1.2, 0.0)), thing(21, box, (2.2, 2.2, 0.0)))
    renderer = Renderer(before, QUICK)
    renderer.update(moved)
    fresh = Renderer(moved, QUICK)
    fresh.exposure = renderer.exposure

    now, then = renderer.render(DOWN, CAMERA), fresh.render(DOWN, CAMERA)
    assert np.array_equal(now.instance_id, then.instance_id)
    np.testing.assert_allclose(now.depth_m, then.depth_m, atol=1e-6)
    assert np.abs(now.rgb.astype(int) - then.rgb.astype(int)).mean() < 4


def test_many_edits_in_a_row_leave_nothing_behind() -> None:
    box = cube(0.4)
    renderer = Renderer(tiny_room(thing(20, box, (1.0, 1.8, 0.0))), QUICK)
    for x in (1.2, 1.4, 1.6):
        renderer.update(tiny_room(thing(20, box, (x, 1.8, 0.0))))
    renderer.update(tiny_room())

    assert 20 not in renderer.render(DOWN, CAMERA).instance_id


def test_what_a_thing_stood_on_exactly_is_there_when_it_is_gone() -> None:
    box = cube(0.4)
    room = tiny_room(thing(20, box, (1.5, 1.6, 0.0)), thing(21, cube(0.5), (0.5, 2.5, 0.0)))
    renderer = Renderer(room, QUICK)
    renderer.update(tiny_room(thing(21, room.things[-1].mesh, (0.5, 2.5, 0.0))))
    fresh = Renderer(renderer.room, QUICK).render(DOWN, CAMERA)

    now = renderer.render(DOWN, CAMERA)
    assert np.array_equal(now.instance_id, fresh.instance_id)
    np.testing.assert_allclose(now.depth_m, fresh.depth_m, atol=2e-6)


def test_a_hole_in_a_texture_shows_what_is_behind() -> None:
    texture = np.full((8, 8, 4), 255, np.uint8)
    texture[:4, :, 3] = 0  # the upper half
    leaf = sheet((1.0, 2.0, 0.7), (1.0, 0, 0), (0, 0, 1.0), Material((1, 1, 1), texture))
    rendering = Renderer(tiny_room(thing(9, leaf)), QUICK).render(AHEAD, CAMERA)

    assert rendering.instance_id[40, 80] == 4
    assert rendering.depth_m[40, 80] == pytest.approx(2.5, abs=1e-3)
    assert rendering.instance_id[75, 80] == 9
    assert rendering.depth_m[75, 80] == pytest.approx(1.5, abs=1e-4)


def test_glass_is_seen_through_but_has_a_depth_of_its_own() -> None:
    pane = sheet((1.0, 2.0, 0.7), (1.0, 0, 0), (0, 0, 1.0), Material((0, 0, 0), opacity=0.2))
    solid = sheet((1.0, 2.0, 0.7), (1.0, 0, 0), (0, 0, 1.0), Material((0, 0, 0)))
    glass, black = (Renderer(tiny_room(thing(9, m)), QUICK) for m in (pane, solid))
    seen = glass.render(AHEAD, CAMERA)

    assert seen.instance_id[60, 80] == 9
    assert seen.depth_m[60, 80] == pytest.approx(1.5, abs=1e-5)
    assert seen.rgb[60, 80].min() > 2 * black.render(AHEAD, CAMERA).rgb[60, 80].max()


def test_what_glows_is_bright_whatever_light_falls_on_it() -> None:
    lamp = sheet((1.0, 2.0, 0.7), (1.0, 0, 0), (0, 0, 1.0), Material((1, 0.9, 0.8), emission=50.0))
    rendering = Renderer(tiny_room(thing(9, lamp)), QUICK).render(AHEAD, CAMERA)

    assert rendering.rgb[60, 80].min() > 240


def test_edges_are_mixed_where_ids_are_not() -> None:
    black = sheet((1.0, 2.0, 0.7), (1.0, 0, 0.1), (-0.1, 0, 1.0), Material((0, 0, 0)))
    room = tiny_room(thing(9, black))
    smooth, sharp = (Renderer(room, replace(QUICK, edge_rays=n)) for n in (3, 0))
    one, other = smooth.render(AHEAD, CAMERA), sharp.render(AHEAD, CAMERA)

    def between(rgb):
        return ((rgb > 60) & (rgb < 130)).sum()

    assert np.array_equal(one.instance_id, other.instance_id)
    assert between(one.rgb) > between(other.rgb) + 50


def test_a_room_without_lights_is_dark_and_does_not_fail() -> None:
    room = replace(tiny_room(), lights=())

    assert Renderer(room, QUICK).render(AHEAD, CAMERA).rgb.max() == 0


def test_a_thing_of_several_materials_shows_each() -> None:
    left = sheet((1.0, 2.0, 0.7), (0.5, 0, 0), (0, 0, 1.0), Material((0.8, 0.1, 0.1)))
    right = sheet((1.5, 2.0, 0.7), (0.5, 0, 0), (0, 0, 1.0), Material((0.1, 0.1, 0.8)))
    rgb = Renderer(tiny_room(thing(9, joined(left, right))), QUICK).render(AHEAD, CAMERA).rgb

    assert rgb[60, 60].argmax() == 0
    assert rgb[60, 100].argmax() == 2


@pytest.mark.parametrize("name", ["shadow_rays", "gather_rays", "threads", "texture_px"])
def test_a_quality_of_nothing_is_refused_by_name(name: str) -> None:
    with pytest.raises(ValueError, match=name):
        Quality(**{name: 0})
