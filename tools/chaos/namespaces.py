"""Two machines on one: network namespaces with a link between them that can be thin, or cut."""

import contextlib
import os
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass

PREFIX = "10.77"
READY = "ready"
HOLD = f"mount -t tmpfs tmpfs /dev/shm && echo {READY} && exec sleep infinity"
BURST_BYTES = 32 * 1024
LATENCY_MS = 50
"""How long a full queue of the thin link takes to send; what comes beyond that is lost."""


class NotPermittedError(Exception):
    """This process may not make network namespaces; the text says what it lacks."""


@dataclass(frozen=True, slots=True)
class Machine:
    """A network namespace with its own loopback, shared memory and address ``host`` on the link.

    ``pid`` is the process that holds it all.
    """

    name: str
    host: str
    device: str
    pid: int

    def command(self, *arguments: str) -> list[str]:
        """Return what runs ``arguments`` there."""
        return ["nsenter", "--target", str(self.pid), "--mount", "--net", "--", *arguments]


@dataclass(frozen=True, slots=True)
class Pair:
    """Two machines and what joins them."""

    edge: Machine
    server: Machine

    def cut(self) -> None:
        """Let nothing through, without telling either side: the ends of the link stay up."""
        self._silence(True)

    def heal(self) -> None:
        """Let everything through again."""
        self._silence(False)

    def _silence(self, silent: bool) -> None:
        """Send to a hardware address that nobody has: as silent as a cable cut far away."""
        for here, there in ((self.edge, self.server), (self.server, self.edge)):
            link = _address_of(there)
            wrong = "02:00:00:00:00:01" if silent else link
            where = ("dev", here.device, "lladdr", wrong, "nud", "permanent")
            _run(*here.command("ip", "neigh", "replace", there.host, *where))

    def limit(self, mbit_s: float) -> None:
        """Let each direction carry at most so much."""
        for machine in (self.edge, self.server):
            rate = (
                "rate",
                f"{mbit_s}mbit",
                "burst",
                str(BURST_BYTES),
                "latency",
                f"{LATENCY_MS}ms",
            )
            shape = ("tc", "qdisc", "replace", "dev", machine.device, "root", "tbf", *rate)
            _run(*machine.command(*shape))

    def sent_bytes(self) -> tuple[int, int]:
        """Return what the edge and the server have sent over the link."""
        sent = []
        for machine in (self.edge, self.server):
            counter = f"/sys/class/net/{machine.device}/statistics/tx_bytes"
            sent.append(int(_run(*machine.command("cat", counter))))
        return sent[0], sent[1]


def _address_of(machine: Machine) -> str:
    return _run(*machine.command("cat", f"/sys/class/net/{machine.device}/address")).strip()


@contextlib.contextmanager
def two_machines() -> Iterator[Pair]:
    """Make two machines joined by a link, and remove them at the end of the block.

    Raises:
        NotPermittedError: no root, no ``ip``, or the kernel refuses.
    """
    need_permission()
    mark = os.getpid()
    net = f"{PREFIX}.{mark % 250}"
    with (
        _machine(f"sq-edge-{mark}", f"{net}.1", f"sqe{mark}") as edge,
        _machine(f"sq-server-{mark}", f"{net}.2", f"sqs{mark}") as server,
    ):
        _join(edge, server)
        yield Pair(edge, server)


@contextlib.contextmanager
def _machine(name: str, host: str, device: str) -> Iterator[Machine]:
    """Data must not pass through shared memory, as it would between processes of one machine."""
    _run("ip", "netns", "add", name)
    try:
        with subprocess.Popen(
            ["ip", "netns", "exec", name, "sh", "-c", HOLD], stdout=subprocess.PIPE, text=True
        ) as holder:
            try:
                assert holder.stdout is not None
                if holder.stdout.readline().strip() != READY:
                    raise NotPermittedError("shared memory of its own: mount is not permitted")
                yield Machine(name, host, device, holder.pid)
            finally:
                holder.kill()
    finally:
        subprocess.run(["ip", "netns", "delete", name], capture_output=True, check=False)


def need_permission() -> None:
    """Raise ``NotPermittedError`` with what is missing to make network namespaces."""
    for program in ("ip", "tc", "nsenter"):
        if shutil.which(program) is None:
            raise NotPermittedError(f"no {program} on this machine")
    if os.geteuid() != 0:
        raise NotPermittedError("making network namespaces needs root")
    probe = f"sq-probe-{os.getpid()}"
    done = subprocess.run(
        ["ip", "netns", "add", probe], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise NotPermittedError(f"the kernel refuses network namespaces: {done.stderr.strip()}")
    subprocess.run(["ip", "netns", "delete", probe], capture_output=True, check=False)


def _join(edge: Machine, server: Machine) -> None:
    ends = (edge.device, "netns", edge.name, "type", "veth", "peer", "name", server.device)
    _run("ip", "link", "add", *ends, "netns", server.name)
    for machine in (edge, server):
        _run(*machine.command("ip", "addr", "add", f"{machine.host}/24", "dev", machine.device))
        for device in (machine.device, "lo"):
            _run(*machine.command("ip", "link", "set", device, "up"))


def _run(*command: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise NotPermittedError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stdout
