"""The sheet of three views."""

import numpy as np
import pytest

from sceneq_core.picture.colours import MARK_COLOURS
from sceneq_core.picture.panel import draw_panel, point_colours
from sceneq_core.picture.projection import from_above, from_corner
from sceneq_core.picture.scene import Cloud, Thing
from sceneq_core.picture.sheet import Heading, draw_sheet

from support.furnished_cloud import BOX_M, BOXES, cloud, mark, only, open_room, things

SIZE = (800, 500)
HEADING = Heading("room", "6 instances", "“box”: found")


def redness(image: np.ndarray) -> np.ndarray:
    wanted = np.array(MARK_COLOURS[0], float)
    return np.abs(image.astype(float) - wanted).sum(axis=-1) < 150


def test_the_same_scene_gives_the_same_picture() -> None:
    first = draw_sheet(cloud(), things(), [mark(11)], HEADING, SIZE)
    assert first.shape == (500, 800, 3)
    assert (first == draw_sheet(cloud(), things(), [mark(11)], HEADING, SIZE)).all()


def test_a_marked_thing_has_its_colour_where_it_is_and_only_with_the_mark() -> None:
    scene = open_room()
    points = scene.points_world.astype(float)
    x, y = BOXES[11]
    middle = np.array([[x + 0.8 * BOX_M, y + 0.2 * BOX_M, BOX_M]])
    for view in (
        from_above(points, np.eye(3), (400, 300)),
        from_corner(points, np.eye(3), -45.0, (400, 300)),
    ):
        for marks, expected in (([mark(11)], True), ([], False)):
            colours = point_colours(scene, things(), marks)
            image = draw_panel(view, scene, colours, [], marks).image
            (u, v), _ = (a[0] for a in view.project(middle))
            around = image[round(v) - 4 : round(v) + 5, round(u) - 4 : round(u) + 5]
            assert (redness(around).mean() > 0.5) == expected


def test_a_marked_thing_shows_through_what_hides_it() -> None:
    scene = cloud()
    view = from_above(scene.points_world.astype(float), np.eye(3), (400, 300))
    marks = [mark(12)]
    with_mark = draw_panel(view, scene, point_colours(scene, [], marks), [], marks).image
    without = draw_panel(view, scene, point_colours(scene, [], marks), [], []).image
    x, y = BOXES[12]
    (u, v), _ = (a[0] for a in view.project(np.array([[x + 0.4, y + 0.1, BOX_M]])))
    before, after = (im[round(v), round(u)].astype(int) for im in (without, with_mark))
    assert after[0] - after[2] > before[0] - before[2] + 40


def test_captions_are_counted_and_the_rest_left_out() -> None:
    scene = open_room()
    view = from_above(scene.points_world.astype(float), np.eye(3), (400, 300))
    colours = point_colours(scene, things(), [])
    panel = draw_panel(view, scene, colours, things(), [])
    assert panel.visible == 5  # the ceiling is not there
    assert panel.captioned == 4  # the wall from above is too thin for its number
    long = [Thing(n, "x" * 80, 0.4, True, (0.5, 0.5, 0.5)) for n in BOXES]
    assert draw_panel(view, scene, colours, long, []).captioned == 0


def test_nothing_to_draw_and_too_small_a_sheet_are_refused() -> None:
    scene = cloud()
    nothing = only(scene, np.zeros(len(scene.points_world), np.bool_))
    with pytest.raises(ValueError, match="no points"):
        draw_sheet(nothing, [], [], HEADING, SIZE)
    with pytest.raises(ValueError, match="400 x 250"):
        draw_sheet(scene, [], [], HEADING, (300, 200))


@pytest.mark.parametrize("instance_id", [0, 1])
def test_a_map_of_one_voxel_is_drawn(instance_id: int) -> None:
    """The first frame may have shown next to nothing, all of it loose points or a wall."""
    one = Cloud(
        points_world=np.zeros((1, 3), np.float32),
        rgb=np.full((1, 3), 200, np.uint8),
        instance_id=np.full(1, instance_id, np.int32),
        voxel_size_m=0.02,
        up_world=np.array([0.0, 0.0, 1.0]),
    )
    sheet = draw_sheet(one, [], [], Heading("one", "voxel", ""), SIZE)
    assert sheet.shape == (500, 800, 3)
    assert len(np.unique(sheet.astype(np.int32) @ (1, 256, 65536))) > 5
