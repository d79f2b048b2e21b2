"""Where the picture of a graph goes: a web page, a file, or a Rerun viewer elsewhere."""

import logging
import re
import socket
import threading
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any
from urllib.parse import urlsplit

log = logging.getLogger(__name__)

APPLICATION = "sceneq"
MEMORY = re.compile(r"[1-9]\d*(MiB|GiB)")
REACH_S, OPEN_S = 0.3, 1.0


@dataclass(frozen=True, slots=True)
class OutputParams:
    """Of ``serve``, ``save`` and ``connect`` none means ``serve``; ``connect`` goes alone.

    serve: offer a web page on ``web_port``, its data on ``grpc_port``, both on ``host``
    (127.0.0.1: this machine only; 0.0.0.0: all; nobody is asked for a password).
    save: file to write, ending in .rrd.
    connect: a Rerun viewer, such as rerun+http://127.0.0.1:9876/proxy.
    memory: what the server keeps for those who come later; the oldest goes first.
    """

    serve: bool = False
    save: str = ""
    connect: str = ""
    host: str = "127.0.0.1"
    web_port: int = 9090
    grpc_port: int = 9876
    memory: str = "512MiB"

    def __post_init__(self) -> None:
        for name in ("web_port", "grpc_port"):
            if not 0 < getattr(self, name) < 65536:
                raise ValueError(f"{name}: {getattr(self, name)} is not in 1..65535")
        if self.web_port == self.grpc_port:
            raise ValueError(f"grpc_port: {self.grpc_port} is the web_port too")
        if not MEMORY.fullmatch(self.memory):
            raise ValueError(f"memory: {self.memory!r}: expected such as 512MiB or 2GiB")
        if self.save and not self.save.endswith(".rrd"):
            raise ValueError(f"save: {self.save!r} does not end in .rrd")
        if self.connect and (self.serve or self.save):
            raise ValueError("connect: goes without serve and save")
        if self.connect and not _is_viewer(self.connect):
            raise ValueError(f"connect: {self.connect!r}: expected rerun+http://HOST:PORT/proxy")

    @property
    def serves(self) -> bool:
        """Whether a web page is offered."""
        return self.serve or not (self.save or self.connect)

    @property
    def page(self) -> str:
        """The web page's address on this machine."""
        name = "127.0.0.1" if self.host in ("0.0.0.0", "127.0.0.1") else self.host
        data = f"rerun%2Bhttp://{name}:{self.grpc_port}/proxy"
        return f"http://{name}:{self.web_port}/?url={data}&theme=dark"


class Output:
    """Opens recordings and keeps what waits for a reader bounded.

    A server forgets the oldest data and a file takes all. A viewer elsewhere may be absent or slow,
    and the library would keep everything for it: so it is looked for before anything is logged, and
    nothing more should be logged while it has not taken the last (``waiting``).
    """

    def __init__(self, params: OutputParams, recording_id: str, layout: Any) -> None:
        self._params = params
        self._recording_id = recording_id
        self._layout = layout
        self._recording: Any = None
        self._handing_on: threading.Thread | None = None

    def open(self) -> None:
        """Take the ports and make the file; raise ``ValueError`` when that cannot be done."""
        import rerun as rr

        params = self._params
        if params.save:
            _need_writable(Path(params.save))
        if params.serves:
            for port in (params.web_port, params.grpc_port):
                _need_free(params.host, port)
            rr.serve_web_viewer(web_port=params.web_port, open_browser=False)

    def recording(self) -> tuple[Any, bool]:
        """Return the open recording, ``None`` without a reader, and whether it is a new one."""
        if self._recording is not None:
            return self._recording, False
        self._recording = self._reach() if self._params.connect else self._start()
        return self._recording, self._recording is not None

    def arrange(self, layout: Any) -> None:
        """Show ``layout`` from now on, also to those who come later."""
        self._layout = layout
        self._recording.send_blueprint(layout)

    @property
    def waiting(self) -> bool:
        """Whether a viewer elsewhere has still to take what was logged last, or to let us in."""
        return self._handing_on is not None and self._handing_on.is_alive()

    def flush(self) -> None:
        """Hand on what was logged; nobody waits for a viewer elsewhere, who may never take it."""
        if not self._params.connect:
            self._recording.flush(timeout_sec=0.0)
            return
        hand_on = partial(self._hand_on, self._recording)
        self._handing_on = threading.Thread(target=hand_on, name="flush", daemon=True)
        self._handing_on.start()

    def close(self) -> None:
        """End the recording."""
        if self._recording is not None and not self.waiting:
            self._recording.disconnect()
        self._recording = None

    def _reach(self) -> Any:
        """Return a recording to a viewer elsewhere, ``None`` when it does not take one soon.

        On a thread of its own: one that listens and takes no byte would hold up who opens it.
        """
        if not _answers(self._params.connect):
            return None
        opened: SimpleQueue[Any] = SimpleQueue()
        self._handing_on = threading.Thread(
            target=lambda: opened.put(self._start()), name="reach", daemon=True
        )
        self._handing_on.start()
        try:
            recording = opened.get(timeout=OPEN_S)
        except Empty:
            return None
        self._handing_on.join()
        return recording

    def _hand_on(self, recording: Any) -> None:
        """On a thread of its own: look for the viewer again when it is gone."""
        try:
            recording.flush()
        except RuntimeError as error:
            log.warning("the viewer at %s is gone: %s", self._params.connect, error)
            self._recording = None
            recording.disconnect()

    def _start(self) -> Any:
        import rerun as rr

        recording = rr.RecordingStream(APPLICATION, recording_id=self._recording_id)
        recording.set_sinks(*self._sinks(), default_blueprint=self._layout)
        return recording

    def _sinks(self) -> list[Any]:
        import rerun as rr

        params = self._params
        sinks: list[Any] = []
        if params.connect:
            sinks.append(rr.GrpcSink(params.connect))
        if params.serves:
            server = rr.GrpcServerSink(
                params.host,
                params.grpc_port,
                server_memory_limit=params.memory,
                newest_first=True,
                cors_allow_origin=[f"http://*:{params.web_port}"],
            )
            sinks.append(server)
        if params.save:
            sinks.append(rr.FileSink(params.save))
        return sinks


def need_rerun() -> None:
    """Raise ``ValueError`` naming the package when Rerun cannot be imported."""
    try:
        import rerun  # noqa: F401
    except ImportError as error:
        raise ValueError(
            f"the viewer needs the package rerun-sdk ({error}): pip install 'rerun-sdk>=0.41'"
        ) from error


def _is_viewer(url: str) -> bool:
    try:
        parts = urlsplit(url)
        known = parts.scheme in ("rerun", "rerun+http", "rerun+https")
        return known and bool(parts.hostname and parts.port) and parts.path == "/proxy"
    except ValueError:
        return False


def _answers(url: str) -> bool:
    parts = urlsplit(url)
    try:
        with socket.create_connection((parts.hostname, parts.port), REACH_S):
            return True
    except OSError:
        return False


def _need_writable(path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.open("ab").close()
    except OSError as error:
        raise ValueError(f"save: {path}: {error.strerror}") from error


def _need_free(host: str, port: int) -> None:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise ValueError(f"cannot listen on {host}:{port}: {error.strerror}") from error
