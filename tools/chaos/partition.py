"""A robot that maps while its link to a server is cut, and processes on both sides are killed.

After each fault the mirrors on both machines must hold the same map, views and descriptors: one
that hears every change, and one that asks for what changed, as over a thin link.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial

from sceneq_tools.chaos.namespaces import NotPermittedError, Pair, two_machines
from sceneq_tools.chaos.robot_and_server import (
    EDGE,
    SERVER,
    THERE,
    BrokenError,
    RobotAndServer,
    Setup,
    faulty_graph,
)
from sceneq_tools.chaos.scenario import NOTHING, Outcome, Plan, skipped

FAULT = "two machines"
WRITERS, SHORT_WRITERS = ("mapping", "views", "encoding"), ("mapping",)
CUTS_S, SHORT_CUTS_S = (3.0, 8.0, 15.0, 60.0), (3.0, 12.0)
"""Sessions end after 5 s of silence: below that a link carries on, above it begins anew."""
SETTLE_S = 60.0
DEFAULT = Setup()
SOME_FRAMES = 3


def run(plan: Plan, setup: Setup = DEFAULT) -> Iterator[Outcome]:
    """Yield what came of each fault; they happen one after the other to the same two machines."""
    with ExitStack() as stack:
        try:
            pair = stack.enter_context(two_machines())
        except NotPermittedError as error:
            yield skipped(FAULT, str(error))
            return
        graph = faulty_graph(pair, setup, plan.work)
        both = stack.enter_context(RobotAndServer(pair, graph, plan.work))
        cuts_s = SHORT_CUTS_S if plan.short else CUTS_S
        yield _outcome("server joins late", partial(_join_late, both), both)
        for cut_s in cuts_s:
            name = f"link cut for {cut_s:g} s"
            yield _outcome(name, partial(_cut, both, pair, cut_s), both)
        for node in SHORT_WRITERS if plan.short else WRITERS:
            yield _outcome(f"kill -9 of {node}", partial(both.kill, EDGE, node), both)
        yield _outcome("kill -9 of the mirror", partial(both.kill, SERVER, THERE), both)
        if not plan.short:
            yield _outcome("kill -9 of mapping, link cut", partial(_cut_and_kill, both, pair), both)


def _outcome(fault: str, harm: Callable[[], object], both: RobotAndServer) -> Outcome:
    """Harm, let a few more frames come, hold still and compare."""
    try:
        before = both.frames()
        harm()
        both.wait(
            "more frames in the map", lambda: both.frames() >= before + SOME_FRAMES or not before
        )
        with both.still():
            took_s = both.wait("equal digests", lambda: not both.difference(), SETTLE_S)
    except BrokenError as error:
        return Outcome(fault, 1, both.difference() or str(error), False, str(error))
    said = both.mirrored(SERVER, THERE)
    detail = f"equal {took_s:.1f} s after the last frame: map {said['map']}, {said['map_digest']}"
    return Outcome(fault, 1, NOTHING, True, detail)


def _join_late(both: RobotAndServer) -> None:
    both.start(EDGE)
    both.wait("frames in the map", lambda: both.frames() >= SOME_FRAMES)
    both.start(SERVER)


def _cut(both: RobotAndServer, pair: Pair, cut_s: float) -> None:
    """The robot goes on meanwhile: that frames come is part of the fault."""
    frames = both.frames()
    pair.cut()
    try:
        time.sleep(cut_s)
    finally:
        pair.heal()
    if both.frames() <= frames:
        raise BrokenError(f"no frame came into the map in {cut_s:g} s without the link")


def _cut_and_kill(both: RobotAndServer, pair: Pair) -> None:
    pair.cut()
    try:
        both.kill(EDGE, "mapping")
        time.sleep(SHORT_CUTS_S[0])
    finally:
        pair.heal()
