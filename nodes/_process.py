"""From ``python -m sceneq_nodes`` to an exit code: parameters, bus, loop, end.

Exit codes: 0 stopped by a signal, 1 a bug (the launcher restarts the node), 2 bad input (it does
not).
"""

import contextlib
import faulthandler
import gc
import logging
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from threading import Event
from typing import Any

from sceneq_nodes._backends import load
from sceneq_nodes._bus import Context, Node, Received
from sceneq_nodes._counters import Counters
from sceneq_nodes._health import Health, metrics
from sceneq_nodes._launch import Launch, RouterLaunch, read_launch
from sceneq_nodes._lifecycle import Stop
from sceneq_nodes._logs import about_message, set_up_logs
from sceneq_nodes._params import validate
from sceneq_nodes._runtime import ZenohBus, close, open_router
from sceneq_schemas.topics import HEALTH, METRIC

log = logging.getLogger(__name__)

STOPPED, BUG, BAD_INPUT = 0, 1, 2
SLICE_S = 0.1
"""How long the loop waits for a message before it looks at the stop event."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what the arguments and the environment say; return the exit code."""
    faulthandler.enable()
    try:
        launch = read_launch(sys.argv[1:] if arguments is None else arguments)
        if isinstance(launch, RouterLaunch):
            _prepare("router", launch.scene)
            return run_router(launch)
        return run_alone(launch)
    except (ValueError, ConnectionError) as error:
        print(f"sceneq: {error}", file=sys.stderr)
        return BAD_INPUT


def run_alone(launch: Launch, node_class: type[Node] | None = None) -> int:
    """Make this process the node that ``launch`` names, or ``node_class``; return the exit code.

    Raises:
        ValueError: an unknown kind or a bad parameter.
    """
    _prepare(launch.context.node, launch.context.scene)
    _make_store(launch.context)
    node_class = node_class or load("nodes", launch.kind)
    return run(node_class, validate(node_class.Params, launch.params), launch)


def run(node_class: type[Node], params: Any, launch: Launch) -> int:
    """Run one node until a signal comes or something fails; return the exit code."""
    counters = Counters()
    health = Health(launch.kind, counters)
    leave = contextlib.ExitStack()
    stop = Stop(leave=leave.close)
    stop.install()
    log.info("connecting to %s", launch.endpoint)
    bus = ZenohBus(launch.context, launch.endpoint, counters)
    leave.callback(bus.close)
    leave.callback(health.beat(lambda: _publish_health(bus, health), stop.event))
    try:
        return _live(node_class(params, launch.context), bus, health, stop.event)
    finally:
        leave.close()


def run_router(launch: RouterLaunch) -> int:
    """Route until a signal comes; raise ``ConnectionError`` when the port is taken."""
    session = open_router(launch.listen, launch.connect, launch.credentials)
    stop = Stop(leave=lambda: close(session))
    stop.install()
    log.info("listening on %s", ", ".join(launch.listen))
    while not stop.event.wait(SLICE_S):
        continue
    close(session)
    return STOPPED


def _live(node: Node, bus: ZenohBus, health: Health, stop: Event) -> int:
    """Open, step and close ``node``."""
    try:
        node.open(bus)
    except ValueError as error:
        log.error("cannot start: %s", error)
        return BAD_INPUT
    except Exception:
        log.exception("cannot start")
        return BUG
    # What was loaded stays; to look through it for garbage again and again stops every thread.
    gc.collect()
    gc.freeze()
    bus.announce(str(os.getpid()))
    health.state = "ready"
    health.hurry()
    log.info("ready")
    try:
        return _loop(node, bus, health, stop)
    finally:
        health.state = "stopping"
        node.close()


def _loop(node: Node, bus: ZenohBus, health: Health, stop: Event) -> int:
    last = time.monotonic()
    while not stop.is_set():
        received = bus.take(min(SLICE_S, node.idle_s))
        if received is None and time.monotonic() - last < node.idle_s:
            continue
        with about_message(received and received.message):
            if not _survives(node, received, health):
                return STOPPED if stop.is_set() else BUG
        last = time.monotonic()
    return STOPPED


def _survives(node: Node, received: Received | None, health: Health) -> bool:
    """Take one step; tell whether it went well."""
    try:
        with health.step():
            node.step(received)
    except Exception:
        seq = getattr(received.message, "seq", None) if received else None
        log.exception("step failed on %s seq %s", received.key if received else "idle", seq)
        return False
    return True


def _publish_health(bus: ZenohBus, health: Health) -> None:
    node = bus.context.node
    message = health.message(node, bus.depths())
    bus.publish(HEALTH, message, node=node)
    bus.publish(METRIC, {"node": node, "metrics": metrics(message)}, node=node)


def _make_store(context: Context) -> None:
    """Make the folder of the scene's durable files, for its owner's eyes only.

    Where that is impossible the node runs all the same; who writes there says what fails.
    """
    if context.store is None:
        return
    try:
        for folder in (context.store.parent, context.store):
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    except OSError as error:
        log.error("store %s: %s; nothing of this run will be kept", context.store, error.strerror)


def _prepare(name: str, scene: str) -> None:
    """Name the process in its log and in ``top``; raise ``ValueError`` for an unknown log form."""
    set_up_logs(name, scene)
    with contextlib.suppress(OSError):
        Path("/proc/self/comm").write_text(f"sceneq-{name}")
