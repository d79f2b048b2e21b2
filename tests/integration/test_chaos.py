"""`sceneq chaos --short`: real processes are killed, flooded and lied to, and nothing is lost."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

VICTIMS = ("router", "mapping", "views", "encoding", "routing")

pytestmark = [pytest.mark.integration, pytest.mark.timeout(900)]


def test_the_short_list_of_faults_does_no_harm(tmp_path: Path) -> None:
    table = tmp_path / "chaos.json"
    done = subprocess.run(
        [sys.executable, "-m", "sceneq_tools", "chaos", "--short", "--json", str(table)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    outcomes = json.loads(table.read_text())["outcomes"]
    assert {one["scenario"] for one in outcomes} == {
        *("kill", "blackout", "clients", "malformed", "bombs", "fuzz")
    }
    assert all(one["passed"] and one["times"] for one in outcomes)
    killed = {one["fault"] for one in outcomes if one["scenario"] == "kill"}
    assert killed == {f"kill -9 of {node}" for node in VICTIMS}
    assert sum(one["times"] for one in outcomes if one["scenario"] == "fuzz") >= 4_000


def test_scenarios_are_listed_and_unknown_ones_refused() -> None:
    listed = _chaos("--list")
    assert {"kill", "partition", "overload", "full-disk", "fuzz"} <= set(listed.stdout.split())
    unknown = _chaos("earthquake")
    assert unknown.returncode == 2
    assert "no scenario named 'earthquake'" in unknown.stderr


def _chaos(*arguments: str) -> "subprocess.CompletedProcess[str]":
    command = [sys.executable, "-m", "sceneq_tools", "chaos", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)
