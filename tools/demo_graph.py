"""A graph that the demo starts, watches through its heartbeats, and ends."""

import contextlib
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any, TypeVar

from sceneq_nodes._client import Client
from sceneq_schemas.topics import HEALTH
from sceneq_tools import scenes
from sceneq_tools.errors import UserError
from sceneq_tools.ports import free_port
from sceneq_tools.status import from_health

READY_S = 90.0
POLL_S = 0.2
STOP_S = 15.0
WRONG = re.compile(r"was ended by|ended with exit code|hangs \(|given up|supervisord died")
"""What `sceneq up` says when a process did not do what it should."""
HOPELESS = 4
"""So many ends that nobody asked for are no accident."""
SHOWN_LINES = 12
DEFAULT_PORT = 7447

T = TypeVar("T")


class DemoGraph:
    """``sceneq up`` as a child whose output goes to a file, to be used in a ``with`` block.

    Attributes:
        endpoint: where its router listens.
        client: connected once ``connect`` has returned.
    """

    def __init__(self, options: list[str], log: Path) -> None:
        """Start it; ``options`` are those of `sceneq up` but for the port."""
        port = _free_port()
        self.endpoint = f"tcp/127.0.0.1:{port}"
        self.client: Client
        self._values: dict[str, dict[str, Any]] = {}
        self._log = log
        log.parent.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "sceneq_tools", "up", *options, "--port", str(port)]
        with log.open("wb") as out:
            self._up = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT)

    def __enter__(self) -> "DemoGraph":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if hasattr(self, "client"):
            self.client.close()
        self._up.send_signal(signal.SIGINT)
        try:
            self._up.wait(STOP_S)
        except subprocess.TimeoutExpired:
            self._up.kill()

    def connect(self) -> None:
        """Wait for the router and listen to the heartbeats.

        Raises:
            UserError: the graph ended, or the router does not answer in time.
        """
        self.client = self.wait(self._client, READY_S, "the router did not answer")
        self.client.subscribe(HEALTH.selector(), self._note)

    def scene(self, patience_s: float = READY_S) -> str:
        """Wait until there is something to ask about; return its scene.

        Raises:
            UserError: the graph ended, or nothing appeared in time.
        """
        return self.wait(self._answerable, patience_s, "no instance appeared")

    def wait(self, what: Callable[[], T | None], patience_s: float, complaint: str) -> T:
        """Return the first value of ``what`` that is neither ``None`` nor false."""
        deadline_s = time.monotonic() + patience_s
        while time.monotonic() < deadline_s:
            self.need_running()
            if value := what():
                return value
            time.sleep(POLL_S)
        raise UserError(f"{complaint} within {patience_s:g} s\n{self.last_words()}")

    def value(self, node: str, name: str, default: Any = 0) -> Any:
        """Return what a node last said of itself."""
        return self._values.get(node, {}).get(name, default)

    @property
    def console(self) -> str:
        """Where a browser finds the map; "" when no gateway runs."""
        port = self.value("gateway", "port")
        return f"http://127.0.0.1:{port}" if port else ""

    def stay(self) -> None:
        """Keep the graph going until Ctrl-C.

        Raises:
            UserError: the graph ended.
        """
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                self.need_running()
                time.sleep(POLL_S)

    def need_running(self) -> None:
        """Raise ``UserError`` when the graph has ended, or a process of it ends again and again."""
        if (code := self._up.poll()) is not None:
            raise UserError(f"the graph ended:\n{self.last_words()}", code or 1)
        if len(troubles := self.troubles()) >= HOPELESS:
            raise UserError("the graph does not run:\n" + "\n".join(troubles[:HOPELESS]))

    def troubles(self) -> list[str]:
        """Return what went wrong so far, as `sceneq up` told it."""
        return [line for line in self._lines() if WRONG.search(line)]

    def last_words(self) -> str:
        """Return the end of what the graph has printed."""
        return "\n".join(self._lines()[-SHOWN_LINES:])

    def _lines(self) -> list[str]:
        return self._log.read_text(errors="replace").splitlines()

    def _client(self) -> Client | None:
        try:
            return Client(self.endpoint)
        except ConnectionError:
            return None

    def _answerable(self) -> str | None:
        found = scenes.scene_status(self.client).items()
        return next((scene for scene, status in found if status.get("answerable")), None)

    def _note(self, key: str, encoding: str, payload: bytes) -> None:
        status = from_health(key, payload)
        if status is not None:
            self._values[status.kind] = dict(status.values)


def _free_port() -> int:
    """Return the port everything uses by itself if nobody has it, else any free one."""
    from sceneq_tools.graph_plan import need_free_port

    try:
        need_free_port(f"tcp/127.0.0.1:{DEFAULT_PORT}")
    except UserError:
        return free_port()
    return DEFAULT_PORT
