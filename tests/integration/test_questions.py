"""Every form of question, put to a running graph with the third-party command line.

The lines are those of docs/questions.md, which is how the page stays true: what it prints is asked
here of a small room, and has to come back in the same form with the same fields.
"""

import base64
import json
import re
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from support.live_graph import LiveGraph, run
from support.shared_room import BLUE_BOX, RED_BALL, SharedRoom

pytestmark = pytest.mark.integration

PAGE = (Path(__file__).parents[2] / "docs" / "questions.md").read_text()
EXAMPLE = re.compile(
    r"^\$ zenoh [^\n]* get -s '([^']+)' --decoder json\n(\{.*?\})\n```", re.M | re.S
)
EXAMPLES = [(selector, json.loads(reply)) for selector, reply in EXAMPLE.findall(PAGE)]
OF_THE_ANSWER = {"missing", "nearest_miss", "gone", "where", "last_seen"}
"""Fields that depend on what is there, not on the form alone."""


@pytest.fixture(scope="module")
def live(room: SharedRoom) -> LiveGraph:
    return room.live


def asked(live: LiveGraph, text: str, topic: str = "ask", **more: str) -> dict[str, Any]:
    parameters = "".join(f";{name}={value}" for name, value in more.items())
    (answer,) = live.zenoh_get(f"sceneq/query/room/{topic}?q={text}{parameters}")
    return answer


def centre(answer: dict[str, Any]) -> Any:
    return np.array(answer["instances"][0]["centre"])


def test_the_page_has_all_the_forms() -> None:
    forms = {reply["form"] for _, reply in EXAMPLES if "form" in reply}
    assert forms == {"find", "where", "what", "count", "exists", "when"}
    assert sum("targets" in reply for _, reply in EXAMPLES) == 1
    assert sum("/label?" in selector for selector, _ in EXAMPLES) >= 1


@pytest.mark.parametrize(("selector", "shown"), EXAMPLES, ids=[s for s, _ in EXAMPLES])
def test_the_page_is_true(live: LiveGraph, selector: str, shown: dict[str, Any]) -> None:
    here = selector.replace("query/house/", "query/room/")
    (answer,) = live.zenoh_get(re.sub(r"\bid=\d+", f"id={an_id(live)}", here))
    assert shown.keys() - OF_THE_ANSWER <= answer.keys()
    assert answer.get("form") == shown.get("form")
    assert bool(answer.get("said")) == bool(shown.get("said"))


_IDS: list[int] = []


def an_id(live: LiveGraph) -> int:
    """Return the id of the red ball, asked for once."""
    if not _IDS:
        _IDS.append(asked(live, "red thing", "instances")["instances"][0]["id"])
    return _IDS[0]


def test_things_are_counted_where_they_are(live: LiveGraph) -> None:
    answer = asked(live, "how many red things are there?")
    assert answer["count"]["sure"] + answer["count"]["possible"] >= 1
    assert np.linalg.norm(centre(answer) - RED_BALL) < 0.15
    on = asked(live, "what is on the brown thing?")
    found = [one["centre"] for one in on["instances"]]
    for place in (RED_BALL, BLUE_BOX):
        assert min(np.linalg.norm(np.subtract(one, place)) for one in found) < 0.15


def test_several_things_at_once(live: LiveGraph) -> None:
    answer = asked(live, "the red thing and the blue thing")
    places = [np.array(one["instances"][0]["centre"]) for one in answer["targets"]]
    assert np.linalg.norm(places[0] - RED_BALL) < 0.15
    assert np.linalg.norm(places[1] - BLUE_BOX) < 0.15


def test_the_order_from_the_left(live: LiveGraph) -> None:
    answer = asked(live, "the red thing left of the blue thing", mode="reason")
    assert answer["route"] == "reasoned"
    assert "seen from the viewer" in answer["reason"]
    assert np.linalg.norm(centre(answer) - RED_BALL) < 0.15


def test_a_crop_is_a_question(live: LiveGraph, tmp_path: Path) -> None:
    rgb = np.full((48, 48, 3), (205, 30, 30), np.uint8)
    crop = base64.b64encode(cv2.imencode(".png", rgb[..., ::-1])[1].tobytes()).decode()
    cli = str(Path(sys.executable).with_name("zenoh"))
    done = run(
        cli, "--mode", "client", "--connect", live.endpoint, "get",
        "-s", "sceneq/query/room/instances", "-v", crop, "--encoder", "base64",
        "--decoder", "json",
    )  # fmt: skip
    answer = json.loads(done.stdout[done.stdout.index("{") :])
    assert answer["form"] == "picture"
    assert np.linalg.norm(centre(answer) - RED_BALL) < 0.15


def test_any_labels_and_the_stream_of_names(live: LiveGraph) -> None:
    key = f"sceneq/query/room/label?id={an_id(live)};labels=green thing,red thing"
    (answer,) = live.zenoh_get(key)
    assert [one["label"] for one in answer["labels"]] == ["red thing", "green thing"]
    (snapshot,) = live.zenoh_get("sceneq/label/room/@snapshot/v1", decoder="sceneq")
    assert "model_id" in snapshot
    assert "hash-v1" in snapshot
    assert "encoder" in snapshot
