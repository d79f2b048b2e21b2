"""Zenoh's endpoints: ``tcp/HOST:PORT?metadata#options``."""

import re

EXTRAS = re.compile(r"[?#].*")


def bare(endpoint: str) -> str:
    """Return ``tcp/HOST:PORT``, without metadata and options."""
    return EXTRAS.sub("", endpoint)


def host_and_port(endpoint: str) -> tuple[str, str]:
    """Return the two as they are written; an IPv6 address keeps its brackets."""
    host, _, port = bare(endpoint).partition("/")[2].rpartition(":")
    return host, port
