"""Other processes of a bench: a router, and one that answers."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from sceneq_nodes._client import Client
from sceneq_tools.ports import free_port

STOP_S = 5.0
CONNECT_S = 10.0


@contextmanager
def router() -> Iterator[str]:
    """Run a router in a process of its own; yield its endpoint as soon as it answers."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with running("sceneq_nodes", "router", "--endpoint", endpoint, errors=subprocess.DEVNULL):
        Client(endpoint, CONNECT_S).close()
        yield endpoint


@contextmanager
def helper(module: str, *arguments: str) -> Iterator[str]:
    """Run ``python -m module`` until the end of the block; yield the first line it prints.

    Raises:
        ConnectionError: it ended instead; what it said is on stderr.
    """
    with running(module, *arguments) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        if not line:
            raise ConnectionError(f"{module} ended with exit code {process.wait(STOP_S)}")
        yield line.strip()


@contextmanager
def running(
    module: str, *arguments: str, errors: int | None = None
) -> Iterator["subprocess.Popen[str]"]:
    """Run a module until the end of the block; ``errors``: where its stderr goes, None = ours."""
    command = [sys.executable, "-m", module, *arguments]
    pipe = subprocess.PIPE
    process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=errors, text=True)
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.communicate(timeout=STOP_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
