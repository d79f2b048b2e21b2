"""Everything ends at once, at random moments, and the next start goes on as if nothing had been."""

import contextlib
import os
import random
import signal
import time
from collections.abc import Iterator
from pathlib import Path

from sceneq_tools.chaos.known import FRAMES, SHORT_FRAMES, live, settled, undisturbed
from sceneq_tools.chaos.live_graph import LiveGraph
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan

ROUNDS, SHORT_ROUNDS = 2, 1
AT_A_TIME, SHORT_AT_A_TIME = 5, 2
PLAYING_S, STARTING_S = 0.3, 3.0
STARTING_SHARE = 0.3
"""So many of the ends come while the graph starts, some within a recovery."""
FAULT = "kill -9 of all processes at once, new start"
GONE_S, POLL_S = 10.0, 0.02


def blackout(plan: Plan) -> Iterator[Outcome]:
    """Kill -9 of all processes at once, the router too, again and again in one scene."""
    whole, chance = undisturbed(plan), random.Random(f"{plan.seed} blackout")
    losses, times, moments = set(), 0, []
    for number in range(plan.pick(ROUNDS, SHORT_ROUNDS)):
        store = ("--store", str(plan.work / str(number)))
        for keyframe in _keyframes(plan, chance):
            with live(plan, *store) as graph:
                _wait(graph, keyframe, chance)
                moments.append(str(graph.value("mapping", "frame_seq")))
                end_all(graph)
                times += 1
        with live(plan, *store) as graph:
            losses.add(settled(graph).lost(whole))
    lost = "; ".join(sorted(losses - {NOTHING})) or NOTHING
    detail = f"newest keyframe each time: {', '.join(moments)}"
    yield Outcome(FAULT, times, lost, lost == NOTHING, detail)


def end_all(graph: LiveGraph) -> None:
    """Kill `up`, what would start the others again, and all others; wait until they are gone."""
    pids = _with_descendants(graph.process.pid)
    for pid in pids:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    graph.process.wait()
    deadline_s = time.monotonic() + GONE_S
    while any(map(_runs, pids)):
        if time.monotonic() > deadline_s:
            raise TimeoutError("processes that were killed are still there")
        time.sleep(POLL_S)


def _keyframes(plan: Plan, chance: random.Random) -> list[int]:
    """Return after which keyframe it ends each time."""
    every = range(plan.pick(FRAMES, SHORT_FRAMES) - 1)
    return sorted(chance.sample(every, plan.pick(AT_A_TIME, SHORT_AT_A_TIME)))


def _wait(graph: LiveGraph, keyframe: int, chance: random.Random) -> None:
    is_starting, share = chance.random() < STARTING_SHARE, chance.random()
    if is_starting:
        time.sleep(share * STARTING_S)
        return
    graph.wait(lambda: (graph.value("mapping", "frame_seq") or -1) >= keyframe)
    time.sleep(share * PLAYING_S)


def _with_descendants(pid: int) -> list[int]:
    """Return a process and all that came of it, parents first."""
    parents = {number: parent for number in _numbers() if (parent := _parent(number))}
    found = [pid]
    for one in found:
        found += (number for number, parent in parents.items() if parent == one)
    return found


def _numbers() -> Iterator[int]:
    return (int(path.name) for path in Path("/proc").iterdir() if path.name.isdigit())


def _parent(pid: int) -> int:
    """Return the parent of a process, 0 when there is no such process any more."""
    fields = _fields(pid)
    return int(fields[1]) if fields else 0


def _runs(pid: int) -> bool:
    fields = _fields(pid)
    return bool(fields) and fields[0] != "Z"


def _fields(pid: int) -> list[str]:
    """Return state, parent and what follows of a process."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return []
