"""What an instance is called in a picture."""

from collections.abc import Mapping
from typing import Any

NAMED_FROM_P = 0.3
"""Less probable names are left out of a picture: their objects go by number."""


def caption(record: Mapping[str, Any]) -> str:
    """Return id and name of a listed instance (``id``, ``label``, ``p``)."""
    named = record["p"] >= NAMED_FROM_P
    return f"{record['id']} {record['label']}" if named else str(record["id"])
