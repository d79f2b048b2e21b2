"""Which processes hang: alive for the system, dead for everybody else."""

from sceneq_tools.graph import ROUTER, WatchdogLimits

OWN_STALL_S = 1.5
"""Checks come a few times a second; when they do not, it was us who slept."""


class Watchdog:
    """Remembers heartbeats; a node is watched from its first one until ``forget``.

    Args:
        limits: how long a node may be silent, and how long inside one step.
    """

    def __init__(self, limits: WatchdogLimits) -> None:
        self._limits = limits
        self._heard_s: dict[str, float] = {}
        self._busy_s: dict[str, float] = {}
        self._checked_s: float | None = None

    def beat(self, node: str, now_s: float, busy_s: float = 0.0) -> None:
        """Note a heartbeat of ``node``, which has been ``busy_s`` seconds in its present step."""
        self._heard_s[node] = now_s
        self._busy_s[node] = busy_s

    def forget(self, node: str) -> None:
        """Stop watching ``node`` until it beats again, as after a restart."""
        self._heard_s.pop(node, None)
        self._busy_s.pop(node, None)

    def forget_all(self) -> None:
        """Stop watching everybody, as after a restart of the router."""
        self._heard_s.clear()
        self._busy_s.clear()

    def hung(self, now_s: float) -> dict[str, str]:
        """Return name -> reason of what has to be killed.

        When all of several nodes fall silent at once it is the router that hangs.
        """
        self._forgive_own_stall(now_s)
        silent = [n for n, heard in self._heard_s.items() if now_s - heard > self._limits.silent_s]
        if len(silent) > 1 and len(silent) == len(self._heard_s):
            return {ROUTER: f"no heartbeat of any node for {self._limits.silent_s:g} s"}
        reasons = dict.fromkeys(silent, f"no heartbeat for {self._limits.silent_s:g} s")
        for node, busy in self._busy_s.items():
            if busy > self._limits.busy_s:
                reasons.setdefault(node, f"{busy:.0f} s inside one step")
        return reasons

    def _forgive_own_stall(self, now_s: float) -> None:
        """A suspended or starved machine is nobody's fault: the clock stood still for all."""
        slept = 0.0 if self._checked_s is None else now_s - self._checked_s
        if slept > OWN_STALL_S:
            self._heard_s = {node: heard + slept for node, heard in self._heard_s.items()}
        self._checked_s = now_s
