"""`sceneq sim` and `sceneq up --sim`: what is sent, what is told, what is refused."""

import json
import sys
from collections.abc import Callable
from typing import Any

import pytest

from sceneq_nodes._bus import QueryError, Reply
from sceneq_tools import cli, scenes
from sceneq_tools.up_command import sim_overrides

Outcome = tuple[int, str, str]
MUG = {
    "id": 17,
    "label": "mug",
    "colour": "red",
    "relation": "on",
    "on": "desk",
    "on_id": 7,
    "centre_m": [1.0, 2.5, 0.789],
    "size_m": [0.1, 0.1, 0.1],
}


class Simulation:
    """Answers every verb with what the test says."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, dict[str, str]]] = []
        self.reply: dict[str, Any] | QueryError | None = None

    def __enter__(self) -> "Simulation":
        return self

    def __exit__(self, *_: object) -> None:
        self.asked.append(("closed", {}))

    def get(self, key: str, payload: bytes, encoding: str, timeout_s: float) -> Any:
        self.asked.append((key, json.loads(payload)))
        if isinstance(self.reply, QueryError):
            return [], [self.reply]
        if self.reply is None:
            return [], []
        return [(key, Reply(json.dumps(self.reply).encode(), "application/json"))], []


@pytest.fixture
def simulation(monkeypatch: pytest.MonkeyPatch) -> Simulation:
    simulation = Simulation()
    monkeypatch.setattr(scenes, "Client", lambda endpoint: simulation)
    return simulation


@pytest.fixture
def run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Outcome]:
    def run_sceneq(*arguments: str) -> Outcome:
        monkeypatch.setattr(sys, "argv", ["sceneq", *arguments])
        with pytest.raises(SystemExit) as ended:
            cli.main()
        out, err = capsys.readouterr()
        return int(ended.value.code or 0), out, err

    return run_sceneq


@pytest.mark.parametrize(
    ("arguments", "verb", "sent", "reply", "told"),
    [
        (
            ("move", "red mug", "--onto", "desk"),
            "move",
            {"thing": "red mug", "onto": "desk"},
            {"verb": "moved", "was": "red mug on the sofa", **MUG},
            "moved the red mug on the sofa: it is on the desk at 1.00 2.50 0.79 m now\n",
        ),
        (
            ("remove", "7"),
            "remove",
            {"thing": "7"},
            {"verb": "removed", "was": "desk on the floor", "gone": [7, 8, 9]},
            "removed the desk on the floor, and 2 on it\n",
        ),
        (
            ("add", "mug", "--onto", "desk", "--colour", "red"),
            "add",
            {"thing": "mug", "onto": "desk", "colour": "red"},
            {"verb": "added", "was": "", **MUG},
            "added a red mug, number 17: it is on the desk at 1.00 2.50 0.79 m\n",
        ),
        (
            ("look", "mug"),
            "look",
            {"thing": "mug"},
            {"verb": "look", **MUG},
            "the camera goes to the red mug, on the desk at 1.00 2.50 0.79 m\n",
        ),
    ],
)
def test_commands_say_what_was_done_and_where_the_thing_is(
    run: Callable[..., Outcome],
    simulation: Simulation,
    arguments: tuple[str, ...],
    verb: str,
    sent: dict[str, str],
    reply: dict[str, Any],
    told: str,
) -> None:
    simulation.reply = reply
    assert run("sim", *arguments) == (0, told, "")
    assert simulation.asked == [(f"sceneq/ctl/ingest/{verb}", sent), ("closed", {})]
    assert json.loads(run("sim", *arguments, "--json")[1]) == reply


def test_the_list_is_a_table(run: Callable[..., Outcome], simulation: Simulation) -> None:
    simulation.reply = {"room": "office", "seed": 3, "things": [{**MUG, "pixels": 420}]}
    code, out, _ = run("sim", "list", "--node", "camera_1")
    assert code == 0
    assert out.startswith("office 3: 1 things\n")
    row = next(line.split() for line in out.splitlines() if "17" in line)
    assert row == ["17", "red", "mug", "on", "the", "desk", "(7)", "1.00", "2.50", "0.79", "420"]
    assert simulation.asked[0][0] == "sceneq/ctl/camera_1/list"


def test_a_refusal_is_one_line_with_its_hint(
    run: Callable[..., Outcome], simulation: Simulation
) -> None:
    simulation.reply = QueryError("refused", "'mug' fits 2 things: 8 ...; 14 ...", "say its number")
    code, out, err = run("sim", "remove", "mug")
    assert (code, out) == (1, "")
    assert err == "sceneq: 'mug' fits 2 things: 8 ...; 14 ... (say its number)\n"


def test_nobody_there(run: Callable[..., Outcome], simulation: Simulation) -> None:
    code, _, err = run("sim", "list")
    assert code == 1
    assert err.startswith("sceneq: no simulation answers")


@pytest.mark.parametrize("verb", ["list", "move", "remove", "add", "look"])
def test_the_help_names_the_zenoh_command(run: Callable[..., Outcome], verb: str) -> None:
    _, out, _ = run("sim", verb, "--help")
    assert f"'sceneq/ctl/ingest/{verb}" in " ".join(out.split())


def test_a_simulation_goes_over_the_graph() -> None:
    given = sim_overrides("office", 5)
    assert [(o.kind, *o.path, o.value) for o in given] == [
        ("", "scene", "office"),
        ("ingest", "source", {"kind": "sim", "room": "office", "rate_hz": 30.0, "seed": 5}),
        ("ingest", "rate_hz", 30.0),
    ]
    slow = sim_overrides("kitchen", scene="home", rate=10.0)
    assert [o.value for o in slow] == [
        "home",
        {"kind": "sim", "room": "kitchen", "rate_hz": 10.0},
        10.0,
    ]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--seed", "3"), "say --sim ROOM too"),
        (("--sim", "office", "--source", "."), "--sim and --source"),
        (("--sim", "office", "--loop", "--step", "2"), "--sim and --step, --loop"),
        (("--sim", "ofice"), "expected one of kitchen, living_room, office, bedroom, mixed"),
    ],
)
def test_options_that_do_not_go_together_are_refused(
    run: Callable[..., Outcome], arguments: tuple[str, ...], says: str
) -> None:
    code, _, err = run("up", *arguments)
    assert code == 2
    assert says in err
