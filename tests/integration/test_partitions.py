"""A robot and a server on network namespaces: whatever the link does, both end with equal digests.

The longer partitions, 8, 15 and 60 s, and more kills: ``sceneq chaos partition``.
"""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from sceneq_tools.chaos.namespaces import NotPermittedError, need_permission
from sceneq_tools.chaos.partition import run
from sceneq_tools.chaos.robot_and_server import Setup
from sceneq_tools.chaos.scenario import NOTHING, Plan

from support.recording import write_recording
from support.room import Room

pytestmark = [pytest.mark.integration, pytest.mark.timeout(900)]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    room = Room(size=(320, 240), focal_px=260.0)
    return write_recording(tmp_path_factory.mktemp("data") / "room", frames=30, room=room)


@pytest.fixture
def work() -> Iterator[Path]:
    """A short path: unix sockets live in it."""
    with tempfile.TemporaryDirectory(prefix="sq") as folder:
        yield Path(folder)


def test_mirrors_end_with_equal_digests_whatever_happens_to_link_and_nodes(
    recording: Path, work: Path
) -> None:
    try:
        need_permission()
    except NotPermittedError as error:
        pytest.skip(f"no network namespaces: {error}")
    outcomes = list(run(Plan(work, work, short=True), Setup(source=recording)))
    assert [outcome.fault for outcome in outcomes] == [
        "server joins late",
        "link cut for 3 s",
        "link cut for 12 s",
        "kill -9 of mapping",
        "kill -9 of the mirror",
    ]
    assert [outcome for outcome in outcomes if not outcome.passed] == []
    assert {outcome.lost for outcome in outcomes} == {NOTHING}
