"""Runs scenarios, each in a folder of its own, and tells of them."""

import contextlib
import os
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from sceneq_tools.chaos.registry import load
from sceneq_tools.chaos.scenario import Outcome, Plan

SCHEMA = "sceneq.chaos.v1"
DEFAULT_COUNT = 200_000
ASIDE = frozenset({"partition"})
"""Waits most of its time, for links that are cut."""
Done = Mapping[str, Sequence[Outcome]]


def outcomes(
    names: Sequence[str], seed: int, short: bool, count: int
) -> Iterator[tuple[str, Outcome]]:
    """Yield (scenario, outcome) as they come; a scenario that itself fails is a failed outcome.

    Those ``ASIDE`` run beside the others.
    """
    with tempfile.TemporaryDirectory(prefix="sceneq-chaos-") as folder:
        shared = Path(folder) / "shared"
        shared.mkdir()

        def run(lane: Sequence[str]) -> Iterator[tuple[str, Outcome]]:
            for name in lane:
                work = Path(folder) / name
                work.mkdir()
                yield from _told(name, Plan(work, seed, short, count, shared))

        aside = [name for name in names if name in ASIDE and len(names) > 1]
        waiting: SimpleQueue[tuple[str, Outcome] | None] = SimpleQueue()

        def run_aside() -> None:
            for told in run(aside):
                waiting.put(told)
            waiting.put(None)

        threading.Thread(target=run_aside, name="aside", daemon=True).start()
        yield from run([name for name in names if name not in aside])
        yield from iter(waiting.get, None)


def _told(name: str, plan: Plan) -> Iterator[tuple[str, Outcome]]:
    began_s = time.monotonic()
    try:
        for outcome in load(name)(plan):
            yield name, outcome
    except Exception as error:
        took = f"after {time.monotonic() - began_s:.0f} s"
        reason = f"{type(error).__name__} {took}: {error}"
        yield name, Outcome(name, 1, "the scenario itself", False, reason)


def rows(done: Done, seed: int, count: int) -> Iterator[tuple[str, ...]]:
    """Yield the cells of the table."""
    for name, found in done.items():
        for one in found:
            cells = one.fault, str(one.times), one.lost, one.verdict, _brief(one.detail)
            yield *cells, command(name, seed, count)


def as_json(done: Done, seed: int, count: int) -> dict[str, Any]:
    """Return the table, and on what it was made."""
    return {
        "schema": SCHEMA,
        "sceneq": version("sceneq"),
        "cores": len(os.sched_getaffinity(0)),
        "outcomes": [
            {"scenario": name, **asdict(one), "command": command(name, seed, count)}
            for name, found in done.items()
            for one in found
        ],
    }


def command(name: str, seed: int, count: int) -> str:
    """Return what does it again."""
    fuzzed = f" --count {count}" if name == "fuzz" and count != DEFAULT_COUNT else ""
    return f"sceneq chaos {name} --seed {seed}{fuzzed}"


def _brief(detail: str) -> str:
    with contextlib.suppress(IndexError):
        return detail.splitlines()[0][:160]
    return ""
