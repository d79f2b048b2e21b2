"""`sceneq chaos --short`: real processes are killed, flooded and lied to, and nothing is lost.

Typed as docs/reliability.md has it, with what support/command_ways.py says of a command behind it.
"""

import json
import subprocess
import sys
from typing import Any

import pytest

from sceneq_tools.chaos.registry import SHORT

from support.command_ways import row_of, shortened
from support.reader import Reader

VICTIMS = ("router", "mapping", "views", "encoding", "routing")
DISK = ("disk full", "started again after a full disk")
PATIENCE_S = 900.0

pytestmark = [pytest.mark.integration, pytest.mark.timeout(PATIENCE_S)]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, ...], list[Any]]:
    """What came of every documented command, by the scenarios it names.

    All of them and the short list are one once they are short.
    """
    folder = tmp_path_factory.mktemp("chaos")
    reader = Reader(folder, folder, patience_s=PATIENCE_S)
    outcomes: dict[tuple[str, ...], list[Any]] = {}
    for command in shortened(__file__):
        table = folder / f"{len(outcomes)}.json"
        text = command.text.partition("  #")[0].rstrip()
        named = tuple(word for word in text.partition(" --")[0].split()[2:])
        if named not in outcomes:
            done = reader.types(text, row_of(command).more, "--json", str(table))
            assert done.code == 0, done.printed
            outcomes[named] = json.loads(table.read_text())["outcomes"]
    return outcomes


def test_no_fault_that_a_reader_can_type_does_harm(told: dict[tuple[str, ...], list[Any]]) -> None:
    assert set(told) == {(), ("full-disk", "bombs"), ("fuzz",)}
    for named, outcomes in told.items():
        assert {one["scenario"] for one in outcomes} == set(named or SHORT)
        assert all(one["passed"] for one in outcomes)


def test_the_short_list_kills_and_feeds_everybody(told: dict[tuple[str, ...], list[Any]]) -> None:
    outcomes = told[()]
    assert set(SHORT) == {"kill", "blackout", "clients", "malformed", "bombs", "fuzz"}
    assert all(one["times"] for one in outcomes)
    killed = {one["fault"] for one in outcomes if one["scenario"] == "kill"}
    assert killed == {f"kill -9 of {node}" for node in VICTIMS}
    assert sum(one["times"] for one in outcomes if one["scenario"] == "fuzz") >= 4_000


def test_a_full_disk_loses_nothing(told: dict[tuple[str, ...], list[Any]]) -> None:
    full = [one for one in told["full-disk", "bombs"] if one["scenario"] == "full-disk"]
    if not full[0]["times"]:
        pytest.skip(full[0]["detail"])  # this machine does not let us mount
    assert tuple(one["fault"] for one in full) == DISK


def test_scenarios_are_listed_and_unknown_ones_refused() -> None:
    listed = _chaos("--list")
    assert {"kill", "partition", "overload", "full-disk", "fuzz"} <= set(listed.stdout.split())
    unknown = _chaos("earthquake")
    assert unknown.returncode == 2
    assert "no scenario named 'earthquake'" in unknown.stderr


def _chaos(*arguments: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "sceneq_tools", "chaos", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)
