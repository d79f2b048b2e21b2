"""Which processes hang: alive for the system, dead for everybody else."""

from sceneq_tools.graph import ROUTER, WatchdogLimits

OWN_STALL_S = 1.5
"""Checks come a few times a second; when they do not, it was us who slept."""
ROUTER_TRIES = 3
"""So often the router is blamed for the silence of all, then the nodes are."""


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
        self._router_blamed = 0

    def beat(self, node: str, now_s: float, busy_s: float = 0.0) -> None:
        """Note a heartbeat of ``node``, which has been ``busy_s`` seconds in its present step."""
        self._heard_s[node] = now_s
        self._busy_s[node] = busy_s
        self._router_blamed = 0

    def forget(self, node: str) -> None:
        """Stop watching ``node`` until it beats again, as after a restart."""
        self._heard_s.pop(node, None)
        self._busy_s.pop(node, None)

    def forgive(self, now_s: float) -> None:
        """Give everybody time to be heard again, as after a restart of the router."""
        self._heard_s = dict.fromkeys(self._heard_s, now_s)
        self._busy_s.clear()

    def hung(self, now_s: float) -> dict[str, str]:
        """Return name -> reason of what has to be killed.

        When all of several nodes fall silent it is the router that hangs. Their last heartbeats
        do not come at once: while nobody is heard no single node is blamed, or a router that
        hangs would cost the map.
        """
        self._forgive_own_stall(now_s)
        limit_s = self._limits.silent_s
        silent = [n for n, heard in self._heard_s.items() if now_s - heard > limit_s]
        if silent and self._nobody_is_heard(now_s):
            if len(silent) < len(self._heard_s):
                return {}
            self._router_blamed += 1
            self.forgive(now_s)
            return {ROUTER: f"no heartbeat of any node for {limit_s:g} s"}
        reasons = dict.fromkeys(silent, f"no heartbeat for {limit_s:g} s")
        for node, busy in self._busy_s.items():
            if busy > self._limits.busy_s:
                reasons.setdefault(node, f"{busy:.0f} s inside one step")
        return reasons

    def _nobody_is_heard(self, now_s: float) -> bool:
        """Tell whether several nodes keep silent, and not for want of a working node."""
        latest_s = max(self._heard_s.values())
        several = len(self._heard_s) > 1 and self._router_blamed < ROUTER_TRIES
        return several and now_s - latest_s > self._limits.silent_s / 2

    def _forgive_own_stall(self, now_s: float) -> None:
        """A suspended or starved machine is nobody's fault: the clock stood still for all."""
        slept = 0.0 if self._checked_s is None else now_s - self._checked_s
        if slept > OWN_STALL_S:
            self._heard_s = {node: heard + slept for node, heard in self._heard_s.items()}
        self._checked_s = now_s
