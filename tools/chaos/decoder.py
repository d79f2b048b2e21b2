"""What a fuzz feeds: something that reads bytes, and valid bytes to damage."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from sceneq_schemas.errors import DecodeError
from sceneq_tools.chaos.mutation import BYTES


class CountedError(Exception):
    """A node has counted an input as refused and gone on; the text is the name of the counter."""


@dataclass(frozen=True, slots=True)
class Decoder:
    """``decode`` returns, or raises one of ``refusals``; anything else is a crash.

    ``form``: what the ``seeds`` are written in, so that damage can keep to it.
    """

    name: str
    decode: Callable[[bytes], object]
    seeds: tuple[bytes, ...]
    form: str = BYTES
    refusals: tuple[type[Exception], ...] = (DecodeError,)


def kind_of(error: Any) -> str:
    """Return what a refusal is counted as."""
    if isinstance(error, CountedError):
        return str(error)
    code = getattr(error, "code", "")
    return f"{type(error).__name__} {code}".strip()
