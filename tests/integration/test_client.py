"""The Python client, its examples and an agent's tools against a running graph."""

import sys
from collections.abc import Iterator
from pathlib import Path

import jsonschema
import pytest
from mcp import Client, StdioServerParameters

from sceneq_client import (
    DisconnectedError,
    NoAnswerError,
    RefusedError,
    SceneError,
    SceneQ,
)
from sceneq_schemas.answer import ANSWER

from support.live_graph import LiveGraph, run
from support.shared_room import RED_BALL, SharedRoom

pytestmark = pytest.mark.integration

PATIENCE_S = 60.0
EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"


@pytest.fixture(scope="module")
def live(room: SharedRoom) -> LiveGraph:
    return room.live


@pytest.fixture
def scene(live: LiveGraph) -> Iterator[SceneQ]:
    with SceneQ(live.endpoint) as scene:
        yield scene


def test_a_question_has_an_answer_with_place_and_picture(scene: SceneQ) -> None:
    assert scene.scene == "room"
    answer = scene.ask("red ball", k=3)
    jsonschema.validate(answer.raw, ANSWER)
    best = answer.instances[0]
    assert best.centre_world == pytest.approx(RED_BALL, abs=0.15)
    assert best.box.low_world < best.centre_world < best.box.high_world
    assert scene.picture(best.views[0]).startswith(b"\xff\xd8")
    assert scene.ask("red ball", mode="fast").route == "fast"


def test_instances_are_listed_labelled_and_taught(scene: SceneQ) -> None:
    listed = list(scene.instances())
    assert [one.id for one in listed] == sorted(one.id for one in listed)
    ball = scene.ask("red ball").instances[0].id
    naming = scene.label(ball, ["ball", "table"])
    assert {name.label for name in naming.names} == {"ball", "table"}
    scene.teach(ball, "Ada's ball")
    assert scene.label(ball).names[0].label == "Ada's ball"
    scene.forget(ball)
    assert scene.label(ball).names[0].label != "Ada's ball"


def test_a_standing_question_tells_what_is_there_and_ends(scene: SceneQ) -> None:
    with scene.watch("red ball", min_p=0.0, k=1) as sightings:
        first = sightings.get(PATIENCE_S)
        assert first is not None
        assert first.instance.centre_world == pytest.approx(RED_BALL, abs=0.15)
    assert sightings.get(0) is None


def test_a_node_that_is_killed_is_waited_for(live: LiveGraph, scene: SceneQ) -> None:
    before = scene.ask("red ball").instances[0].id
    victim = live.pids()["routing"]
    run("kill", "-9", str(victim))
    assert scene.ask("red ball", timeout_s=PATIENCE_S).question == "red ball"
    live.wait(lambda: live.pids()["routing"] != victim)
    live.wait(lambda: [one.id for one in scene.ask("red ball").instances][:1] == [before])


def test_errors_say_what_is_wrong(live: LiveGraph, scene: SceneQ) -> None:
    with pytest.raises(RefusedError, match="no such instance: 9999") as refused:
        scene.label(9999)
    assert refused.value.code == "not_found"
    with pytest.raises(DisconnectedError, match="no router"):
        SceneQ("tcp/127.0.0.1:1", timeout_s=0.5)
    with (
        SceneQ(live.endpoint, "elsewhere") as other,
        pytest.raises(NoAnswerError, match="elsewhere"),
    ):
        other.ask("ball", timeout_s=0.5)
    with pytest.raises(SceneError):
        scene.ask("")


@pytest.mark.parametrize(
    ("name", "arguments", "told"),
    [
        ("find.py", ["red ball"], "bytes of JPEG"),
        ("tell_me.py", ["red ball", "0.0"], "red ball: "),
        ("follow.py", ["red ball", "table"], "table: "),
        ("agent.py", ["red ball"], "tools: ask, list_things, name_of, picture, scene_status"),
    ],
)
def test_the_examples_run(live: LiveGraph, name: str, arguments: list[str], told: str) -> None:
    done = run(sys.executable, str(EXAMPLES / name), live.endpoint, *arguments)
    assert done.returncode == 0, done.stderr
    assert told in done.stdout


async def _talk(endpoint: str) -> None:
    arguments = ["-m", "sceneq_tools", "mcp", "--connect", endpoint]
    async with Client(StdioServerParameters(command=sys.executable, args=arguments)) as host:
        asked = (await host.list_tools()).tools
        assert all("scene" not in tool.input_schema["properties"] for tool in asked)
        answer = (await host.call_tool("ask", {"question": "red ball"})).structured_content
        assert answer["things"][0]["centre_m"] == pytest.approx(list(RED_BALL), abs=0.15)
        things = (await host.call_tool("list_things", {})).structured_content["result"]
        assert answer["things"][0]["id"] in [thing["id"] for thing in things]
        picture = await host.call_tool("picture", {"thing_id": answer["things"][0]["id"]})
        assert picture.content[0].mime_type == "image/jpeg"
        wrong = await host.call_tool("name_of", {"thing_id": 9999})
        assert wrong.is_error
        assert "no such instance: 9999" in wrong.content[0].text


def test_an_agent_asks_looks_and_is_told_its_mistakes(live: LiveGraph) -> None:
    import asyncio

    asyncio.run(_talk(live.endpoint))
