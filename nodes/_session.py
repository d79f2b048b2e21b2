"""How Scene-Q configures a Zenoh session, and why."""

from collections.abc import Sequence
from typing import Any

from sceneq_nodes._credentials import Credentials

SHARED_MEMORY_POOL_BYTES = 64 * 1024 * 1024
DROP_AFTER_US = 20_000
"""How long a full link may hold up a writer before the message is dropped."""
LEASE_MS = 5_000
"""A process that stops answering loses its session, and its liveliness token, after this time."""
QUERY_TIMEOUT_MS = 30_000
MAX_LINKS = 4
"""Between two routers: ``?prio=0-3`` and ``?prio=4-7`` let questions pass where frames queue."""


def client_config(
    endpoint: str, timeout_s: float | None, credentials: Credentials | None = None
) -> dict[str, Any]:
    """Return the configuration of a client of the router at ``endpoint``.

    It waits ``timeout_s`` for the router, ``None`` = for ever, and comes back to it when lost.
    """
    connect = {
        "endpoints": [endpoint],
        "timeout_ms": -1 if timeout_s is None else int(1000 * timeout_s),
        "exit_on_failure": timeout_s is not None,
        "retry": {"period_init_ms": 100, "period_max_ms": 300},
    }
    return {**_common("client", credentials), "connect": connect}


def router_config(
    listen: Sequence[str], connect: Sequence[str], credentials: Credentials | None = None
) -> dict[str, Any]:
    """Return the configuration of a router; it looks for the others it joins all the time.

    Raises:
        ValueError: the access rules among the credentials cannot be read.
    """
    rules = {} if credentials is None else {"access_control": credentials.access()}
    common = _common("router", credentials)
    return {
        **common,
        **rules,
        "transport": {**common["transport"], "unicast": _BETWEEN_ROUTERS},
        "listen": {"endpoints": list(listen)},
        "connect": {
            "endpoints": list(connect),
            "timeout_ms": -1,  # 0 would try once: a robot that starts first would stay alone
            "exit_on_failure": False,
            "retry": {"period_init_ms": 250, "period_max_ms": 1000},
        },
    }


def _common(mode: str, credentials: Credentials | None) -> dict[str, Any]:
    """Return what the sessions of both modes have in common.

    With ``credentials`` links are mutual TLS, and no others are made.

    No multicast: a process talks to its machine's router and to nobody it was not told of, and a
    router does not wait half a second for others that might answer. Only
    published data goes through shared memory; queries stay on the link, in order. What a killed
    process leaves in /dev/shm is removed by the next one that starts; where /dev/shm is small or
    full, data goes over the link instead.
    """
    link = _LINK if credentials is None else {**_LINK, **_encrypted(credentials)}
    return {
        "mode": mode,
        "scouting": {"multicast": {"enabled": False}, "delay": 0},
        "timestamping": {"enabled": True},
        "queries_default_timeout": QUERY_TIMEOUT_MS,
        "transport": {"shared_memory": _SHARED_MEMORY, "link": link},
    }


_SHARED_MEMORY = {
    "transport_optimization": {"pool_size": SHARED_MEMORY_POOL_BYTES, "messages": ["put"]}
}
_LINK = {
    "tx": {
        "lease": LEASE_MS,
        "queue": {
            "size": {"data_high": 16, "data": 16, "data_low": 16},
            "congestion_control": {"drop": {"wait_before_drop": DROP_AFTER_US}},
        },
    },
    "rx": {"buffer_size": 1024 * 1024},
}


_BETWEEN_ROUTERS = {"max_links": MAX_LINKS, "compression": {"enabled": True}}
"""Compression needs both ends to want it: clients do not, so nothing on a machine is slowed."""


def _encrypted(credentials: Credentials) -> dict[str, Any]:
    return {"protocols": ["tls", "quic"], "tls": credentials.link()}
