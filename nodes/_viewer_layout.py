"""What is where on the screen of the viewer."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from sceneq_nodes._viewer_answers import ANSWERS, EVIDENCE, MARKED
from sceneq_nodes._viewer_camera import CAMERA, MASKS
from sceneq_nodes._viewer_eye import Eye
from sceneq_nodes._viewer_map import BOXES, COLOUR, INSTANCES, SUPERPOINTS
from sceneq_nodes._viewer_series import DELAYS, LOST, RATES

TIMELINE = "log_time"
WINDOW_S = 120.0
TITLES = {COLOUR: "map", INSTANCES: "instances", SUPERPOINTS: "superpoints"}
PAPER = (24, 26, 30)


def live_layout(clouds: Sequence[str] = (COLOUR, INSTANCES), eye: Eye | None = None) -> Any:
    """Return the blueprint of a running graph: everything at once, the map largest."""
    import rerun.blueprint as rrb

    left = rrb.Vertical(_maps(clouds, eye), _series(), row_shares=[2.6, 1])
    camera = rrb.Spatial2DView(origin=CAMERA, name="camera and segments")
    right = rrb.Vertical(camera, _answers(), _evidence(), row_shares=[1.8, 1.9, 1])
    return _blueprint(rrb.Horizontal(left, right, column_shares=[2.2, 1]))


def map_layout(eye: Eye | None) -> Any:
    """Return the blueprint of a finished map."""
    return _blueprint(_maps((COLOUR, INSTANCES), eye))


def _blueprint(content: Any) -> Any:
    import rerun.blueprint as rrb

    return rrb.Blueprint(
        content,
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following"),
        auto_views=False,
        auto_layout=False,
    )


def _maps(clouds: Sequence[str], eye: Eye | None) -> Any:
    """Return views of one world that differ in the colours of the cloud and in the boxes."""
    import rerun.blueprint as rrb

    without = {COLOUR: {BOXES}, INSTANCES: {MARKED}, SUPERPOINTS: {BOXES, MARKED}}
    views = [_world(TITLES[path], path, without[path], eye) for path in clouds]
    return rrb.Horizontal(*views, column_shares=[1.15, *[1] * (len(views) - 1)])


def _world(name: str, cloud: str, left_out: set[str], eye: Eye | None) -> Any:
    import rerun.blueprint as rrb

    left_out = left_out | ({COLOUR, INSTANCES, SUPERPOINTS} - {cloud})
    return rrb.Spatial3DView(
        origin="world",
        contents=["$origin/**", *(f"- {path}/**" for path in sorted(left_out)), f"- {MASKS}"],
        name=name,
        background=PAPER,
        line_grid=False,
        eye_controls=None if eye is None else _controls(eye),
    )


def _controls(eye: Eye) -> Any:
    import rerun.blueprint as rrb

    return rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=eye.position.astype(np.float32),
        look_target=eye.target.astype(np.float32),
        eye_up=eye.up.astype(np.float32),
    )


def _series() -> Any:
    import rerun.blueprint as rrb

    titles = {
        RATES: "messages a second",
        DELAYS: "ms after the keyframe",
        LOST: "messages lost so far",
    }
    boundary = rrb.TimeRangeBoundary
    window = rrb.VisibleTimeRange(
        TIMELINE,
        start=boundary.cursor_relative(seconds=-WINDOW_S),
        end=boundary.cursor_relative(),
    )
    legend = rrb.PlotLegend(corner=rrb.Corner2D.LeftTop)
    views = [
        rrb.TimeSeriesView(origin=path, name=title, time_ranges=window, plot_legend=legend)
        for path, title in titles.items()
    ]
    return rrb.Horizontal(*views)


def _answers() -> Any:
    import rerun.blueprint as rrb

    return rrb.TextDocumentView(origin=ANSWERS, name="answers")


def _evidence() -> Any:
    import rerun.blueprint as rrb

    views = [
        rrb.Spatial2DView(origin=path, name=f"evidence {number}", titlebar=False)
        for number, path in enumerate(EVIDENCE, 1)
    ]
    return rrb.Horizontal(*views)
