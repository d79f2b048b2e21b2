"""Processes that end or stand still in the middle of mapping, whichever it is."""

import os
import random
import signal
import time
from collections import Counter
from collections.abc import Callable, Iterator, Sequence

from sceneq_tools.chaos.known import live, settled, undisturbed
from sceneq_tools.chaos.live_graph import LiveGraph
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan

NODES = ("mapping", "views", "encoding", "routing", "segmentation", "ingest", "reasoning")
EVERYBODY = ("router", *NODES)
SHORT_VICTIMS = ("router", "mapping", "views", "encoding", "routing")
AT_A_TIME = 4
PAUSE_S = 2.0
"""Less than the watchdog waits."""
MOST_S = 1.5
Harm = Callable[[LiveGraph, str], int]


def kill(plan: Plan) -> Iterator[Outcome]:
    """Kill -9 of every process, at random moments, several in a run."""
    victims = SHORT_VICTIMS if plan.short else EVERYBODY
    yield from _harmed(plan, kill_one, "kill -9 of", plan.pick(2, 1), victims)


def pause(plan: Plan) -> Iterator[Outcome]:
    """SIGSTOP, and SIGCONT after two seconds."""
    victims = NODES[:4] if plan.short else EVERYBODY
    yield from _harmed(plan, pause_one, f"SIGSTOP for {PAUSE_S:g} s of", 1, victims)


def hang(plan: Plan) -> Iterator[Outcome]:
    """SIGSTOP for good: the watchdog ends the process, and it comes back."""
    victims = NODES[:1] if plan.short else NODES[:4]
    yield from _harmed(plan, hang_one, "SIGSTOP for good of", 1, victims)


def kill_one(graph: LiveGraph, victim: str) -> int:
    """Kill a process; return how many were there to be killed."""
    return _signal(graph.pids().get(victim), signal.SIGKILL)


def pause_one(graph: LiveGraph, victim: str) -> int:
    """Hold a process up."""
    pid = graph.pids().get(victim)
    stopped = _signal(pid, signal.SIGSTOP)
    time.sleep(PAUSE_S)
    _signal(pid, signal.SIGCONT)
    return stopped


def hang_one(graph: LiveGraph, victim: str) -> int:
    """Hold a process up for ever and wait until another one has its place."""
    pid = graph.pids()[victim]
    stopped = _signal(pid, signal.SIGSTOP)
    graph.wait(lambda: graph.pids()[victim] != pid)
    return stopped


def _harmed(
    plan: Plan, harm: Harm, what: str, rounds: int, victims: Sequence[str]
) -> Iterator[Outcome]:
    """Yield an outcome for every victim; one that lost something counts against all in its run."""
    whole, chance = undisturbed(plan), random.Random(plan.seed)
    order = [victim for _ in range(rounds) for victim in chance.sample(victims, len(victims))]
    times: Counter[str] = Counter()
    losses: dict[str, str] = {}
    at_a_time = plan.pick(AT_A_TIME, len(order))
    for number, start in enumerate(range(0, len(order), at_a_time)):
        group = order[start : start + at_a_time]
        with live(plan, "--store", str(plan.work / str(number))) as graph:
            graph.wait_until_begun()
            for victim in group:
                time.sleep(chance.uniform(0.0, MOST_S))
                times[victim] += harm(graph, victim)
            lost = settled(graph).lost(whole)
        losses |= dict.fromkeys(group, lost) if lost != NOTHING else {}
    for victim in victims:
        lost = losses.get(victim, NOTHING)
        yield Outcome(f"{what} {victim}", times[victim], lost, lost == NOTHING)


def _signal(pid: int | None, number: signal.Signals) -> int:
    try:
        if pid:
            os.kill(pid, number)
        return int(bool(pid))
    except ProcessLookupError:  # on its way back from the last time
        return 0
