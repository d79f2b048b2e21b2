"""One graph on a small room for all files that only look at it, and which files run together.

With ``-n 2 --dist loadfile`` a group of files runs in one process, in the order given here; every
other file is a group of its own. Those that take longest begin first.
"""

import signal
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from xdist.scheduler import LoadScopeScheduling

from support.shared_room import SharedRoom, settled_room

HERE = Path(__file__).parent
SHARE = ("test_stream", "test_questions", "test_viewer", "test_client", "test_console", "test_ends")
"""Files on the one graph: those that only read come first, those that kill come last."""
DEMOS = ("test_demo", "test_documents")
"""Files in which `sceneq demo` takes the usual port if that is free."""
LONG = (
    *("test_chaos", "test_documents", "test_partitions", "test_recording", "test_demo"),
    *("test_teach", "test_live_sim", "test_eval_answers", "test_bench", "test_ros"),
)
GROUPS = dict.fromkeys(SHARE, "room") | dict.fromkeys(DEMOS, "demo")
signal.signal(signal.SIGINT, signal.default_int_handler)
"""Who runs the tests may ignore Ctrl-C, and what they start would inherit that."""
SLOW_S = 600
"""A machine may be slow, or have others at work: that is no failure."""


class Groups(LoadScopeScheduling):
    """Gives files to processes, those of a group to one."""

    def _split_scope(self, nodeid: str) -> str:
        name = Path(nodeid.partition("::")[0]).stem
        return GROUPS.get(name, name)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Groups | None:
    return Groups(config, log) if config.getvalue("dist") == "loadfile" else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    places = {name: number for number, name in enumerate((*SHARE, *LONG))}

    def place(item: pytest.Item) -> int:
        return places.get(item.path.stem, len(places)) if item.path.parent == HERE else 0

    for item in items:
        if item.path.parent == HERE and item.get_closest_marker("timeout") is None:
            item.add_marker(pytest.mark.timeout(SLOW_S))
    items.sort(key=place)


@pytest.fixture(scope="session")
def room(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SharedRoom]:
    with (
        tempfile.TemporaryDirectory(prefix="sq") as runtime,  # a short path, for sockets
        settled_room(tmp_path_factory.mktemp("shared"), Path(runtime)) as room,
    ):
        yield room
