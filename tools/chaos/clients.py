"""Many clients at once, clients that never read, and clients that die with a question open."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from sceneq_tools.chaos.client_worker import ANSWERED, NOBODY, TIMEOUT_S
from sceneq_tools.chaos.known import SCENE, live, settled, undisturbed
from sceneq_tools.chaos.live_graph import LiveGraph
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan

PROCESSES = 4
CLIENTS, QUESTIONS = 200, 20
SHORT_CLIENTS, SHORT_QUESTIONS = 40, 5
QUIET_QUESTIONS = 60
SLOWER, SPARE_MS = 4.0, 100.0
"""Others may make a question so much slower, as they use the cores too; not more."""
ENDS = {ANSWERED, "busy"}


def many(plan: Plan) -> Iterator[Outcome]:
    """Every question of many clients ends, in an answer or in ``busy``."""
    clients, questions = plan.pick(CLIENTS, SHORT_CLIENTS), plan.pick(QUESTIONS, SHORT_QUESTIONS)
    whole = undisturbed(plan)
    with live(plan) as graph:
        settled(graph)
        ends, took_ms = crowd(graph, clients, questions, plan.seed)
        lost = settled(graph).lost(whole)
    total = sum(ends.values())
    other = {end: n for end, n in ends.items() if end not in ENDS}
    hung = clients * questions - total + ends[NOBODY] + sum(ms > 1e3 * TIMEOUT_S for ms in took_ms)
    detail = f"{ends[ANSWERED]} answered, {ends['busy']} busy, {hung} hung, {_latency(took_ms)}"
    fine = lost == NOTHING and not other and not hung
    yield Outcome(f"{clients} clients x {questions} questions", total, lost, fine, detail)


def bad(plan: Plan) -> Iterator[Outcome]:
    """Clients that stand still or die, while frames flow, slow nobody down."""
    with live(plan, "--loop") as graph:
        graph.wait(lambda: graph.value("routing", "answerable"))
        before = alone(graph, plan.seed)
        yield _compared(graph, plan, before, "client that listens to all and never reads", "listen")
        yield _compared(graph, plan, before, "client that asks and never reads", "forever")
        yield _dying(graph, plan, before)


def crowd(
    graph: LiveGraph, clients: int, questions: int, seed: int
) -> tuple[Counter[str], list[float]]:
    """Return how the questions of ``clients`` at a time ended, and how long they took (ms)."""
    each = -(-clients // PROCESSES)
    counts = [min(each, clients - begun) for begun in range(0, clients, each)]
    command = [_command(graph, count, questions, seed + n, "ask") for n, count in enumerate(counts)]
    pipe = subprocess.PIPE
    workers = [subprocess.Popen(one, stdout=pipe, text=True) for one in command]
    ends: Counter[str] = Counter()
    took_ms: list[float] = []
    for worker in workers:
        said, _ = worker.communicate()
        result = json.loads(said.splitlines()[-1])
        ends.update(result["ends"])
        took_ms += result["took_ms"]
    return ends, took_ms


def alone(graph: LiveGraph, seed: int) -> list[float]:
    """Return how long the questions of a single client take, ms."""
    ends, took_ms = crowd(graph, 1, QUIET_QUESTIONS, seed)
    if ends.keys() - ENDS:
        raise RuntimeError(f"questions ended in {dict(ends)}")
    return took_ms


@contextmanager
def running(graph: LiveGraph, clients: int, seed: int, what: str) -> Iterator["Worker"]:
    """Run a process of clients, which is killed at the end of the block."""
    command = _command(graph, clients, 1_000_000, seed, what)
    worker = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        assert worker.stdout is not None
        worker.stdout.readline()
        yield worker
    finally:
        worker.kill()
        worker.communicate()


Worker = subprocess.Popen[str]


def _compared(
    graph: LiveGraph, plan: Plan, before: Sequence[float], fault: str, what: str
) -> Outcome:
    """Let a client stand still and see how others fare; the map has to go on, too."""
    with running(graph, 1, plan.seed, what) as worker:
        time.sleep(0.3)
        os.kill(worker.pid, signal.SIGSTOP)
        return _judged(graph, plan, before, fault, 1)


def _dying(graph: LiveGraph, plan: Plan, before: Sequence[float]) -> Outcome:
    times = plan.pick(5, 2)
    for number in range(times):
        with running(graph, 4, plan.seed + number, "forever"):
            time.sleep(0.2)
    return _judged(graph, plan, before, "clients killed with questions open", 4 * times)


def _judged(
    graph: LiveGraph, plan: Plan, before: Sequence[float], fault: str, times: int
) -> Outcome:
    mapped = graph.value("mapping", "frame_seq")
    now = alone(graph, plan.seed + 1)
    graph.wait(lambda: (graph.value("mapping", "frame_seq") or 0) > mapped)
    slower = float(np.median(now)) > SLOWER * float(np.median(before)) + SPARE_MS
    detail = f"others: {_latency(now)}, before: {_latency(before)}"
    return Outcome(fault, times, "time of others" if slower else NOTHING, not slower, detail)


def _latency(took_ms: Sequence[float]) -> str:
    if not took_ms:
        return "no times"
    p50, p99 = np.percentile(took_ms, (50, 99))
    return f"p50 {p50:.0f} ms, p99 {p99:.0f} ms, slowest {max(took_ms):.0f} ms"


def _command(graph: LiveGraph, clients: int, questions: int, seed: int, what: str) -> list[str]:
    said = (SCENE, str(clients), str(questions), str(seed), what)
    return [sys.executable, "-m", "sceneq_tools.chaos.client_worker", graph.endpoint, *said]
