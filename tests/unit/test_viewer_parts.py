"""The parts of the viewer, without a graph."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._bus import Reply
from sceneq_nodes._caption import caption
from sceneq_nodes._viewer_answers import NOTHING, answers_text
from sceneq_nodes._viewer_asking import Asking
from sceneq_nodes._viewer_cloud import kept, thinning_of
from sceneq_nodes._viewer_eye import GROWN, Eyes, open_side
from sceneq_nodes._viewer_output import OutputParams
from sceneq_nodes._viewer_series import Delays, Flows, Lines
from sceneq_schemas.topics import QUERY_INSTANCES
from sceneq_tools.errors import UserError
from sceneq_tools.graph import GraphNode, Router, WatchdogLimits
from sceneq_tools.graph_plan import Plan
from sceneq_tools.viewer_option import output_params, with_viewer

from support.fake_bus import FakeBus
from support.true_map import delta

UP = np.array([0.0, 0.0, 1.0])


class Recording:
    """Keeps what is logged."""

    def __init__(self) -> None:
        self.logged: list[tuple[str, object]] = []

    def log(self, path: str, entity: object, static: bool = False) -> None:
        self.logged.append((path, entity))


def test_a_rate_is_what_was_sent_between_two_heartbeats():
    flows = Flows()
    beat = {"uptime_s": 10.0, "frame.out": 20, "pose.out": 100, "health.out": 9, "frame.in": 50}
    assert flows.take("ingest", beat) == (None, 0.0)
    later = {**beat, "uptime_s": 12.0, "frame.out": 26, "pose.out": 160, "health.out": 11}
    assert flows.take("ingest", later) == (33.0, 0.0)
    assert flows.take("views", {"uptime_s": 5.0, "view_delta.out": 7})[0] is None
    restarted = {**beat, "uptime_s": 1.0, "frame.out": 0, "pose.out": 1}
    assert flows.take("ingest", restarted)[0] is None
    assert flows.take("ingest", {**restarted, "uptime_s": 2.0, "pose.out": 3})[0] == 2.0


def test_losses_are_all_that_did_not_arrive_or_could_not_be_used():
    metrics = {
        "uptime_s": 1.0,
        "mask.dropped": 3,
        "frame.undecodable": 2,
        "frames_skipped": 1,
        "frames_bad": 4,
        "frames_unmatched": 5,
        "pose.dropped": 900,
        "frames_observed": 80,
        "keyframes": 7,
    }
    assert Flows().take("mapping", metrics)[1] == 15.0


def test_delays_are_known_for_keyframes_that_were_seen():
    delays = Delays()
    delays.start(7, 1.0)
    assert delays.since(7, 1.5) == 500.0
    assert delays.since(8, 1.5) is None
    for seq in range(8, 3000):
        delays.start(seq, 2.0)
    assert delays.since(7, 3.0) is None, "what is remembered is bounded"


def test_a_line_without_news_has_a_gap():
    recording = Recording()
    lines = Lines("series/rates", stale_s=3.0)
    lines.log(recording, 0.0)
    assert recording.logged == []
    lines.set("views", 2.0, now_s=0.0)
    lines.set("ingest", None, now_s=5.0)
    lines.log(recording, 1.0)
    lines.log(recording, 5.0)
    values = [entity.scalars.as_arrow_array().to_pylist() for _, entity in recording.logged[1:]]
    np.testing.assert_equal(values, [[2.0, np.nan], [np.nan, np.nan]])
    assert len(recording.logged) == 3, "names are logged once"


@given(st.integers(0, 10**7), st.integers(1, 10**6))
def test_no_more_points_are_shown_than_wanted(count, wanted):
    thinning = thinning_of(count, wanted)
    assert count <= thinning * wanted
    assert thinning == 1 or count > thinning // 2 * wanted
    assert thinning & (thinning - 1) == 0


def test_thinning_keeps_the_same_ids_and_about_the_right_share():
    shown = kept(100_000, 8)
    assert shown.sum() == pytest.approx(100_000 / 8, rel=0.05)
    np.testing.assert_array_equal(kept(50_000, 8), shown[:50_000])
    assert (kept(100_000, 4) >= shown).all(), "a thinner cloud is part of a denser one"
    assert kept(1000, 1).all()


def square(side_m: float) -> MapReplica:
    """Return a map of a floor with a wall on the side of negative x."""
    step = np.arange(0, side_m, side_m / 20)
    floor = np.array([(x, y, 0.0) for x in step for y in step])
    wall = np.array([(0.0, y, z) for y in step for z in step])
    points = np.concatenate([floor, wall]).astype(np.float32)
    replica, ids = MapReplica(), np.arange(len(points), dtype=np.int32)
    coord = np.floor(points / 0.03).astype(np.int32)
    rgb = np.full(points.shape, 90, np.uint8)
    columns = {"voxel_id": ids, "voxel_coord": coord, "points_world": points, "rgb": rgb}
    replica.apply(delta(full=True, superpoint_id=ids, **columns))
    return replica


def test_the_eye_looks_from_above_over_the_open_side():
    eye = Eyes().look(square(4.0))
    away = eye.position - eye.target
    assert away[0] > 0, "the wall is behind the room"
    assert away[2] > 0
    np.testing.assert_allclose(eye.target, [1.9, 1.9, 1.9], atol=0.15)
    np.testing.assert_array_equal(eye.up, UP)


def test_the_eye_moves_only_when_the_map_has_outgrown_it():
    eyes = Eyes()
    assert eyes.look(MapReplica()) is None
    assert eyes.look(square(4.0)) is not None
    assert eyes.look(square(4.0)) is None
    assert eyes.look(square(4.0 * (GROWN - 0.1))) is None
    assert eyes.look(square(4.0 * (GROWN + 0.1))) is not None


def test_the_open_side_does_not_depend_on_where_up_is():
    points = square(4.0).points_world.astype(np.float64)
    offsets = points - points.mean(axis=0)
    turned = offsets[:, [2, 0, 1]]  # x is up now, and the wall at low y
    np.testing.assert_allclose(open_side(offsets, UP), [1, 0, 0], atol=0.3)
    np.testing.assert_allclose(open_side(turned, np.array([1.0, 0, 0])), [0, 1, 0], atol=0.3)


def test_only_probable_names_are_written():
    assert caption({"id": 3, "label": "cup", "p": 0.31}) == "3 cup"
    assert caption({"id": 3, "label": "cup", "p": 0.29}) == "3"


def test_names_are_asked_for_page_by_page():
    bus = FakeBus()

    def page(asked):
        after, count = int(asked.parameters["after"]), int(asked.parameters["k"])
        ids = range(after + 1, min(after + count, 450) + 1)
        records = [{"id": key, "label": "cup", "p": 1.0} for key in ids]
        return Reply(json.dumps({"instances": records}).encode(), "application/json")

    bus.answer(QUERY_INSTANCES, page)
    captions = Asking(bus, "room").captions()
    assert len(captions) == 450
    assert captions[450] == "450 cup"
    assert len(bus.asked) == 3
    assert Asking(FakeBus(), "room").captions() is None


def test_without_a_question_it_says_how_to_ask_one():
    assert answers_text(None, ()) == NOTHING


def test_an_answer_names_its_matches_and_the_answers_before_it():
    views = [{"seq": seq} for seq in (30, 70, 80, 90)]
    match = {"id": 12, "label": "cup", "p": 0.72, "cosine": 0.41, "views": views}
    newest = {
        "question": "red mug",
        "status": "found",
        "route": "fast",
        "took_ms": 3.4,
        "reason": "clear",
        "instances": [match],
    }
    before = {"question": "bicycle", "status": "not_found", "best": [], "route": "fast"}
    lines = answers_text(newest, [{**before, "took_ms": 5.0}]).splitlines()
    assert lines[0] == "### red mug"
    assert lines[2] == "**found** by the fast route in 3 ms: clear"
    assert "| 12 | cup | 0.72 | 0.41 | 30, 70, 80 |" in lines
    assert lines[-1] == "| bicycle (not_found) | - | - | fast | 5 |"


@pytest.mark.parametrize(
    ("params", "field"),
    [
        ({"web_port": 0}, "web_port"),
        ({"grpc_port": 70000}, "grpc_port"),
        ({"web_port": 9876}, "grpc_port"),
        ({"memory": "much"}, "memory"),
        ({"save": "map.ply"}, "save"),
        ({"connect": "tcp/127.0.0.1:7447"}, "connect"),
        ({"connect": "rerun+http://127.0.0.1/proxy"}, "connect"),
        ({"connect": "rerun+http://127.0.0.1:9876/proxy", "serve": True}, "connect"),
    ],
)
def test_an_output_that_cannot_be_is_refused(params, field):
    with pytest.raises(ValueError, match=field):
        OutputParams(**params)


def test_it_serves_unless_told_otherwise():
    assert OutputParams().serves
    assert not OutputParams(save="a.rrd").serves
    assert OutputParams(save="a.rrd", serve=True).serves
    assert not OutputParams(connect="rerun+http://127.0.0.1:9876/proxy").serves


@pytest.mark.parametrize(
    ("output", "params"),
    [
        ("serve", {"serve": True}),
        ("/tmp/a.rrd", {"save": "/tmp/a.rrd"}),
        ("rerun+http://h:9876/proxy", {"connect": "rerun+http://h:9876/proxy"}),
    ],
)
def test_the_option_says_where_the_picture_goes(output, params):
    assert output_params(output) == params


def test_the_option_adds_a_node_to_the_plan():
    plan = Plan("room", "robot", "camera", Router(), WatchdogLimits(), (GraphNode(id="views"),))
    assert with_viewer(plan, None) is plan
    added = with_viewer(plan, "serve").nodes[-1]
    assert (added.id, added.params) == ("viewer", {"output": {"serve": True}})
    for wrong in ("picture.png", "http://somewhere"):
        with pytest.raises(UserError):
            with_viewer(plan, wrong)
    with pytest.raises(UserError, match="already"):
        with_viewer(with_viewer(plan, "serve"), "serve")
