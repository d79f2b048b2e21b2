"""Ports, and whether a message comes through."""

import statistics
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from sceneq_tools.doctor.finding import Finding, ok, problem, warning
from sceneq_tools.ports import free_port

DEFAULT_PORT = 7447
LISTENING = "0A"
OURS = "sceneq_nodes"
SHOWN = 60
FRAME_BYTES = 1_500_000
"""A frame of 640x480, colour and depth, uncompressed."""
LOOPBACK_S = 1.0
PATIENCE_S = 10.0
"""How long the first message is waited for: a busy machine is slow, but not broken."""
WAIT_S = 0.2
MESSAGES = 20
SLOW_MS = 50.0
KEY = "sceneq/@doctor"


def graph_ports() -> list[int]:
    """Return the TCP ports that ``sceneq up`` would listen on, and Zenoh's own.

    Raises:
        UserError: the graph file is wrong; says where.
    """
    from sceneq_tools.graph import default_path, load

    graph, _ = load(default_path())
    listen = [endpoint.partition("?")[0] for endpoint in graph.router.listen]
    ports = [int(endpoint.rpartition(":")[2]) for endpoint in listen if endpoint.startswith("tcp/")]
    return sorted({DEFAULT_PORT, *ports})


def ports(
    wanted: Sequence[int] | None = None,
    holder: Callable[[int], str | None] | None = None,
) -> Finding:
    """Check that the router's ports are free, or held by a graph of ours."""
    wanted = graph_ports() if wanted is None else wanted
    held = {port: who for port in wanted if (who := (holder or port_holder)(port)) is not None}
    foreign = {port: who for port, who in held.items() if OURS not in who}
    if foreign:
        said = ", ".join(f"{port} is held by {_short(who)}" for port, who in foreign.items())
        return problem(said, f"sceneq up --port {free_port()}")
    if held:
        return ok(", ".join(f"{port}: a graph is running" for port in held))
    return ok(f"{', '.join(map(str, wanted))} free")


def port_holder(port: int, processes: Path = Path("/proc")) -> str | None:
    """Return the command that listens on a TCP port of this machine; None = nobody."""
    inodes = {
        inode for table in ("tcp", "tcp6") for inode in _listeners(processes / "net" / table, port)
    }
    if not inodes:
        return None
    for process in processes.glob("[0-9]*"):
        if inodes & _socket_inodes(process):
            words = (process / "cmdline").read_bytes().split(b"\0")
            command = b" ".join(words).decode(errors="replace").strip()
            return f"{command} (pid {process.name})"
    return "a process of another user"


def round_trip() -> Finding:
    """Send frames through a router of our own, for a second once one came through."""
    from sceneq_nodes._client import Client
    from sceneq_nodes._runtime import close, open_router

    endpoint = f"tcp/127.0.0.1:{free_port()}"
    router = open_router([endpoint], [])
    try:
        with Client(endpoint) as sender, Client(endpoint) as receiver:
            arrived = threading.Event()
            receiver.subscribe(KEY, lambda *_: arrived.set())
            return judged(trips_ms(lambda: sender.publish(KEY, bytes(FRAME_BYTES), ""), arrived))
    finally:
        close(router)


def trips_ms(send: Callable[[], None], arrived: threading.Event) -> list[float]:
    """Send up to ``MESSAGES`` one after the other; return how long each that arrived took."""
    began_s, wait_s = time.monotonic(), WAIT_S
    taken_ms: list[float] = []
    while len(taken_ms) < MESSAGES:
        start_s = time.monotonic()
        if start_s - began_s >= (LOOPBACK_S if taken_ms else PATIENCE_S):
            break
        arrived.clear()
        send()
        # The first ones may be sent before the router knows of the reader.
        if arrived.wait(wait_s):
            taken_ms.append(1000 * (time.monotonic() - start_s))
        else:
            wait_s *= 1.5
    return taken_ms


def judged(taken_ms: Sequence[float]) -> Finding:
    """Judge by the median: the first messages set shared memory up."""
    mend = "env RUST_LOG=zenoh=debug sceneq doctor"
    if not taken_ms:
        return problem(f"no message came through within {PATIENCE_S:g} s", mend)
    median_ms = statistics.median(taken_ms)
    said = f"a frame of 1.5 MB goes through the router in {median_ms:.1f} ms"
    return ok(said) if median_ms <= SLOW_MS else warning(f"{said}: slow", mend)


def _short(who: str) -> str:
    """Keep the process number, which ends the text."""
    return who if len(who) <= SHOWN else f"{who[: SHOWN // 2]} ... {who[-SHOWN // 2 :]}"


def _listeners(table: Path, port: int) -> list[str]:
    """Return the socket inodes that listen on ``port`` in a table of the kernel."""
    try:
        rows = [line.split() for line in table.read_text().splitlines()[1:]]
    except OSError:
        return []
    return [row[9] for row in rows if row[3] == LISTENING and _port(row[1]) == port]


def _port(address: str) -> int:
    return int(address.rpartition(":")[2], 16)


def _socket_inodes(process: Path) -> set[str]:
    """Return the sockets of a process; none of one that ended or that we may not look at."""
    try:
        links = [_target(fd) for fd in (process / "fd").iterdir()]
    except OSError:
        return set()
    return {link[len("socket:[") : -1] for link in links if link.startswith("socket:[")}


def _target(fd: Path) -> str:
    """Return what an open file of a process is; '' when it was closed meanwhile."""
    try:
        return str(fd.readlink())
    except OSError:
        return ""
