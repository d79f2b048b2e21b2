"""The demo without a recording: a simulated robot, and what to type beside it."""

import signal
import time
from pathlib import Path
from typing import Any

from sceneq_tools import demo_text
from sceneq_tools.demo_graph import DemoGraph
from sceneq_tools.demo_text import say, waiting
from sceneq_tools.graph import DEFAULT_ENDPOINT
from sceneq_tools.sim_command import control

FLOOR = "floor"
NO_FURNITURE = {FLOOR, "wall", "ceiling", "rug"}
HANDY = {
    *("mug", "cup", "bowl", "vase", "bottle", "teddy", "clock", "book", "candle", "camera"),
    *("jar", "teapot", "kettle", "telephone", "cube"),
}
"""Small things, for which there is room nearly anywhere."""
ENOUGH = 5
"""Instances to ask about before the demo invites."""
WATCH_S = 1.0
PATIENCE_S = 300.0
"""Hundreds of furniture models are read and lit before the first frame."""

Thing = dict[str, Any]


def run_live(room: str, seed: int, graph: Path | None, rate: float | None, out: Path) -> None:
    """Keep a simulated robot going until Ctrl-C; say what to type beside it.

    Raises:
        UserError: the graph ended, or the simulation does not start.
    """
    options = ["--sim", room, "--seed", str(seed)]
    options += ["--rate", f"{rate:g}"] if rate else []
    options += ["--log-dir", str(out / "logs")]
    demo_text.heading(f"Scene-Q live: a simulated robot in {_words(room)} {seed}")
    with DemoGraph([str(graph)] * bool(graph) + options, out / "graph.log") as running:
        with waiting("starting the graph and furnishing the room"):
            running.connect()
            scene = running.scene(PATIENCE_S)
            running.wait(lambda: _knows_enough(running), PATIENCE_S, "the map did not grow")
        things = control(running.endpoint, "ingest", "list", {})["things"]
        _invite(running.endpoint, scene, *example(things))
        _watch(running)


def example(things: list[Thing]) -> tuple[str, str]:
    """Return the name of a thing that is easily moved, and of what it may be put on.

    A name that only one thing has, of something small that stands on furniture; and another piece
    of furniture that carries things already, so that there is room for them.
    """
    labels = [thing["label"] for thing in things]
    single = [thing for thing in things if labels.count(thing["label"]) == 1]
    carried = [thing for thing in single if thing["on_id"] and thing["on"] not in NO_FURNITURE]
    if not carried:
        return (single[0]["label"] if single else "chair"), FLOOR
    handy = [thing for thing in carried if HANDY & set(thing["label"].split())] or carried
    chosen = max(handy, key=lambda thing: (thing["pixels"] or 0, -thing["id"]))
    bearers = {thing["on_id"] for thing in carried} - {chosen["on_id"]}
    others = [thing["label"] for thing in single if thing["id"] in bearers]
    return chosen["label"], (others[0] if others else FLOOR)


def _invite(endpoint: str, scene: str, thing: str, onto: str) -> None:
    where = "" if endpoint == DEFAULT_ENDPOINT else f" --connect {endpoint}"
    router = "" if endpoint == DEFAULT_ENDPOINT else f" --router {endpoint}"
    rows = [
        ("ask", f'sceneq ask "{thing}"{where}'),
        ("or", demo_text.command(endpoint, scene, thing)),
        ("move it", f'sceneq sim move "{thing}" --onto "{onto}"{where}'),
        ("look there", f'sceneq sim look "{thing}"{where}'),
        ("ask again", f'sceneq ask "{thing}"{where}'),
        ("the room", f"sceneq sim list{where}"),
        ("watch", f"sceneq viewer{router}"),
        ("picture", f'sceneq view --png view.png --question "{thing}"{where}'),
        ("health", f"sceneq status{where}"),
    ]
    if activation := demo_text.activation():
        rows.insert(0, ("first", activation))
    say()
    say("The robot looks around. Type in another shell:")
    say()
    demo_text.facts(rows)
    say()
    say("Ctrl-C ends it.")


def _watch(running: DemoGraph) -> None:
    """Say what goes wrong, until Ctrl-C."""
    told = 0

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)
    try:
        while True:
            running.need_running()
            troubles = running.troubles()
            for line in troubles[told:]:
                say(line, "warn")
            told = len(troubles)
            time.sleep(WATCH_S)
    except KeyboardInterrupt:
        say()
        say("ending")


def _knows_enough(running: DemoGraph) -> bool:
    return int(running.value("routing", "answerable")) >= ENOUGH


def _words(room: str) -> str:
    return room.replace("_", " ")
