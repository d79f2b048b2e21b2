"""Zenoh between processes, through a router, beside a plain TCP connection."""

import socket
import threading
import time
from collections.abc import Callable, Iterator

from sceneq_nodes._client import Client
from sceneq_tools.bench.echo import FRAMES, GET, TAKEN, exchange, receive, send
from sceneq_tools.bench.measurement import Measurement, Options, latency, samples_ms
from sceneq_tools.bench.processes import helper, router

SMALL_BYTES = 64
FRAME_BYTES = 1_500_000
"""640x480, colour and depth, uncompressed."""
IN_FLIGHT = 4
LOST_AFTER_S = 1.0
BESIDE = "the same over TCP"


def bus(options: Options) -> Iterator[Measurement]:
    """Measure a small get, a large frame and a stream of frames."""
    with (
        router() as endpoint,
        helper("sceneq_tools.bench.echo", endpoint) as port,
        Client(endpoint) as client,
        _tcp(int(port)) as connection,
    ):
        yield from _small_gets(client, connection, options.seconds)
        yield from _frames(client, connection, options.seconds)


def _small_gets(client: Client, tcp: socket.socket, seconds: float) -> Iterator[Measurement]:
    request = bytes(SMALL_BYTES)
    got = samples_ms(lambda: bare_get(client, SMALL_BYTES), seconds, warm_ups=3)
    bare = samples_ms(lambda: exchange(tcp, request, SMALL_BYTES), seconds)
    yield from latency(f"get of {SMALL_BYTES} B", got, BESIDE, bare)


def _frames(client: Client, tcp: socket.socket, seconds: float) -> Iterator[Measurement]:
    sender, frame = FrameSender(client), bytes(FRAME_BYTES)
    went = samples_ms(lambda: sender.round_trip(frame), seconds, warm_ups=3)
    bare = samples_ms(lambda: exchange(tcp, frame, 1), seconds)
    yield from latency("frame of 1.5 MB", went, BESIDE, bare)
    per_s, bare_per_s = sender.stream(frame, seconds), _tcp_stream(tcp, frame, seconds)
    yield Measurement("stream of frames", per_s, "frames/s", BESIDE, bare_per_s)
    mb = FRAME_BYTES / 1e6
    yield Measurement("stream of frames", mb * per_s, "MB/s", BESIDE, mb * bare_per_s)
    yield Measurement("frames lost", sender.lost, "frames")


def bare_get(client: Client, size: int) -> None:
    """Ask for ``size`` bytes; raise ``ConnectionError`` when they do not come."""
    replies, _ = client.get(f"{GET}?n={size}", timeout_s=LOST_AFTER_S)
    if not replies:
        raise ConnectionError(f"no answer to a get within {LOST_AFTER_S:g} s")


class FrameSender:
    """Publishes frames and hears which were taken."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._taken = threading.Semaphore(0)
        self.lost = 0
        client.subscribe(TAKEN, lambda *_: self._taken.release())

    def round_trip(self, frame: bytes) -> None:
        """Publish a frame and wait until it was taken."""
        self._client.publish(FRAMES, frame, "")
        self._await()

    def stream(self, frame: bytes, seconds: float) -> float:
        """Publish with ``IN_FLIGHT`` on their way; return how many were taken a second."""
        self.lost = 0
        return _stream(lambda: self._client.publish(FRAMES, frame, ""), self._await, seconds)

    def _await(self) -> None:
        if not self._taken.acquire(timeout=LOST_AFTER_S):
            self.lost += 1


def _stream(publish: Callable[[], None], wait: Callable[[], None], seconds: float) -> float:
    start_s = time.perf_counter()
    for _ in range(IN_FLIGHT):
        publish()
    taken = 0
    while time.perf_counter() - start_s < seconds:
        wait()
        taken += 1
        publish()
    for _ in range(IN_FLIGHT):
        wait()
    return (taken + IN_FLIGHT) / (time.perf_counter() - start_s)


def _tcp_stream(connection: socket.socket, frame: bytes, seconds: float) -> float:
    return _stream(lambda: send(connection, frame, 1), lambda: _drop(connection), seconds)


def _drop(connection: socket.socket) -> None:
    receive(connection, 1)


def _tcp(port: int) -> socket.socket:
    connection = socket.create_connection(("127.0.0.1", port))
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection
