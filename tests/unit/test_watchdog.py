"""Who counts as hung, and who does not."""

from sceneq_tools.graph import WatchdogLimits
from sceneq_tools.watchdog import Watchdog

LIMITS = WatchdogLimits(silent_s=3.0, busy_s=10.0)


def ticking(until_s: float, *nodes: str) -> Watchdog:
    """Return a watchdog that heard ``nodes`` every half second up to ``until_s``."""
    watchdog = Watchdog(LIMITS)
    for half_seconds in range(int(2 * until_s) + 1):
        for node in nodes:
            watchdog.beat(node, half_seconds / 2)
        assert watchdog.hung(half_seconds / 2) == {}
    return watchdog


def hung_later(watchdog: Watchdog, from_s: float, to_s: float, *beating: str) -> dict[str, str]:
    hung: dict[str, str] = {}
    for half_seconds in range(int(2 * from_s), int(2 * to_s) + 1):
        for node in beating:
            watchdog.beat(node, half_seconds / 2)
        hung |= watchdog.hung(half_seconds / 2)
    return hung


def test_a_node_is_not_watched_before_its_first_heartbeat() -> None:
    assert hung_later(Watchdog(LIMITS), 0, 100) == {}


def test_silence_beyond_the_limit_is_a_hang() -> None:
    watchdog = ticking(5, "left", "right")
    assert hung_later(watchdog, 5, 8, "right") == {}
    assert hung_later(watchdog, 8, 9, "right") == {"left": "no heartbeat for 3 s"}


def test_a_restarted_node_is_not_watched_until_it_beats() -> None:
    watchdog = ticking(5, "left", "right")
    watchdog.forget("left")
    assert hung_later(watchdog, 5, 60, "right") == {}


def test_when_all_fall_silent_the_router_hangs() -> None:
    watchdog = ticking(5, "left", "right")
    assert hung_later(watchdog, 5, 9) == {"router": "no heartbeat of any node for 3 s"}
    assert hung_later(watchdog, 9.5, 15, "left", "right") == {}


def test_a_router_that_hangs_costs_no_node_although_last_heartbeats_are_not_simultaneous() -> None:
    watchdog = ticking(5, "left", "right", "middle")
    watchdog.beat("left", 5.4)
    watchdog.beat("right", 5.9)
    told = [watchdog.hung(5 + tenth / 10) for tenth in range(1, 41)]
    assert [one for one in told if one] == [{"router": "no heartbeat of any node for 3 s"}]


def test_a_node_that_hangs_while_the_router_restarts_is_found() -> None:
    watchdog = ticking(5, "left", "right")
    watchdog.forgive(5.5)
    assert hung_later(watchdog, 5.5, 9, "right") == {"left": "no heartbeat for 3 s"}


def test_nodes_that_stay_silent_whatever_the_router_does_hang() -> None:
    watchdog = ticking(5, "left", "right")
    assert set(hung_later(watchdog, 5, 17)) == {"router"}
    assert set(hung_later(watchdog, 17, 30)) == {"left", "right"}


def test_a_single_node_that_falls_silent_hangs() -> None:
    assert set(hung_later(ticking(5, "left"), 5, 9)) == {"left"}


def test_a_step_beyond_the_limit_is_a_hang_although_the_heart_beats() -> None:
    watchdog = ticking(1, "left")
    watchdog.beat("left", 1.5, busy_s=9.9)
    assert watchdog.hung(1.5) == {}
    watchdog.beat("left", 2.0, busy_s=10.4)
    assert watchdog.hung(2.0) == {"left": "10 s inside one step"}


def test_nobody_is_blamed_for_the_time_the_machine_slept() -> None:
    watchdog = ticking(5, "left", "right")
    assert watchdog.hung(5000.0) == {}
    assert hung_later(watchdog, 5000, 5002) == {}
    assert set(hung_later(watchdog, 5002, 5005, "right")) == {"left"}
