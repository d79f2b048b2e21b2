"""Processes under ``supervisord``: start, look, kill, stop; no process outlives ``stop``."""

import contextlib
import http.client
import os
import shutil
import signal
import socket
import subprocess
import sys
import time
import xmlrpc.client
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sceneq_tools.errors import UserError
from sceneq_tools.threads import ONE_THREAD

RPC_TIMEOUT_S = 2.0
START_TIMEOUT_S = 10.0
STOP_TIMEOUT_S = 4.5
FATAL, EXITED, STOPPED, BACKOFF = "FATAL", "EXITED", "STOPPED", "BACKOFF"
BUS_LOG = {"RUST_LOG": "error"}


@dataclass(frozen=True, slots=True)
class Process:
    """One supervised process at one moment; ``pid`` is 0 when it does not run."""

    name: str
    group: str
    state: str
    pid: int


class Supervisor:
    """A ``supervisord`` child of this process, bound to its life.

    Args:
        folder: private run directory with ``supervisord.conf``; also holds the control socket.
        environment: variables that every process gets.
    """

    def __init__(self, folder: Path, environment: dict[str, str]) -> None:
        self._folder = folder
        self._environment = ONE_THREAD | BUS_LOG | dict(os.environ) | environment
        self._child: subprocess.Popen[bytes] | None = None
        self._pids: set[int] = set()
        self._rpc: Any = xmlrpc.client.ServerProxy(
            "http://supervisor", transport=_UnixTransport(str(folder / "supervisor.sock"))
        )

    def start(self) -> None:
        """Start supervisord, which starts everything; return when it answers.

        Raises:
            UserError: it ended at once or does not answer.
        """
        self._child = subprocess.Popen(
            [sys.executable, "-P", "-m", "sceneq_tools.lifeline", str(self._folder)],
            stdin=subprocess.PIPE,
            env=self._environment,
            start_new_session=True,
        )
        deadline = time.monotonic() + START_TIMEOUT_S
        while not self.processes():
            if self._child.poll() is not None or time.monotonic() > deadline:
                raise UserError("supervisord did not start; its words are above or in its log")
            time.sleep(0.05)

    def alive(self) -> bool:
        """Tell whether supervisord itself runs."""
        return self._child is not None and self._child.poll() is None

    def processes(self) -> list[Process]:
        """Return all processes, [] when supervisord does not answer in time."""
        try:
            infos = self._rpc.supervisor.getAllProcessInfo()
        except (OSError, http.client.HTTPException, xmlrpc.client.Error):
            return []
        found = [_process(info) for info in infos]
        self._pids.update(process.pid for process in found if process.pid)
        return found

    def kill(self, process: Process) -> None:
        """Kill a process with -9; supervisord brings it back."""
        self._call("signalProcess", f"{process.group}:{process.name}", "KILL")

    def hold(self, process: Process) -> None:
        """Stop a process for good."""
        self._call("stopProcess", f"{process.group}:{process.name}", False)

    def revive(self, process: Process) -> None:
        """Start at once what supervisord lets wait, or has given up, after it ended too soon."""
        name = f"{process.group}:{process.name}"
        with contextlib.suppress(OSError, http.client.HTTPException, xmlrpc.client.Error):
            state = self._rpc.supervisor.getProcessInfo(name)["statename"]
            if state == BACKOFF:
                self._rpc.supervisor.stopProcess(name, False)
            if state in (BACKOFF, FATAL):
                self._rpc.supervisor.startProcess(name, False)

    def stop(self) -> None:
        """Stop everything, within ``STOP_TIMEOUT_S`` by asking, then with -9."""
        if self._child is None:
            return
        if self._child.poll() is None:
            self.processes()
            self._child.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                self._child.wait(STOP_TIMEOUT_S)
        if self._child.poll() != 0:
            self._kill_all()
        shutil.rmtree(self._folder, ignore_errors=True)

    def _call(self, method: str, *arguments: Any) -> None:
        """Do what may be too late: the process can be gone, which is as good."""
        with contextlib.suppress(OSError, http.client.HTTPException, xmlrpc.client.Error):
            getattr(self._rpc.supervisor, method)(*arguments)

    def _kill_all(self) -> None:
        """supervisord hung or was killed: its children are groups of their own, known by pid."""
        assert self._child is not None
        self._child.kill()
        self._child.wait()
        for pid in self._pids:
            if _is_ours(pid, str(self._folder)):
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(pid, signal.SIGKILL)


def _is_ours(pid: int, folder: str) -> bool:
    """A pid may have been given to somebody else; ours carry the run folder's name."""
    try:
        return folder.encode() in Path(f"/proc/{pid}/environ").read_bytes()
    except OSError:
        return False


def _process(info: dict[str, Any]) -> Process:
    return Process(info["name"], info["group"], info["statename"], info["pid"])


class _UnixTransport(xmlrpc.client.Transport):
    """XML-RPC over a Unix socket, with a timeout."""

    def __init__(self, path: str) -> None:
        super().__init__()
        self._path = path

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Return a new connection; supervisord closes each after one call."""
        return _UnixConnection(self._path)


class _UnixConnection(http.client.HTTPConnection):
    def __init__(self, path: str) -> None:
        super().__init__("supervisor", timeout=RPC_TIMEOUT_S)
        self._path = path

    def connect(self) -> None:
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(RPC_TIMEOUT_S)
        self.sock.connect(self._path)
