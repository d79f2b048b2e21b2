"""Reads which choice a model made: JSON when it kept to the form, plain text when it did not.

Nothing is guessed: a reply that names no choice, several or one that is not in the list is none.
"""

import json
import re
from collections.abc import Sequence

MAX_CHARS = 4000
"""Of a longer reply only the end counts: that is where talkative models conclude."""

_THOUGHT = re.compile(r"<think>.*?(</think>|\Z)", re.DOTALL)
_OBJECT = re.compile(r"\{[^{}]*\}")
_WORD = re.compile(r"[a-z]+|\d+(?:\.\d+)?")
_SAYS = r"""(?:\s+(?:is|number|box))*[\s:*"'`(\[]*(none\b|\d+\b(?!\.\d))"""
_CONCLUSIONS = (
    re.compile(r"\b(?:choice|answer)\b" + _SAYS),
    re.compile(r"\b(?:box|number|option|candidate)\b" + _SAYS),
)
"""What counts more comes first: boxes are also spoken of on the way to an answer."""


class UnusableReplyError(ValueError):
    """A reply that names no choice, or several; the text says which of it."""


def read_choice(reply: str, keys: Sequence[str], options: Sequence[str] = ()) -> str:
    """Return the key in ``keys`` that ``reply`` chooses.

    ``options`` are what the keys stand for, in their order: a model may say "mug" instead of "2".

    Raises:
        UnusableReplyError: no choice, more than one, or one that is not in the list.
    """
    text = _THOUGHT.sub(" ", reply[-MAX_CHARS:]).strip()
    named = _stated(text)
    if named is None:
        return _only(_in_plain_text(text, keys, options), keys)
    return _only([_as_key(named, keys, options)], keys)


def _stated(text: str) -> str | None:
    """Return what the last JSON object with a ``choice`` says; ``None`` when there is none."""
    for found in reversed(_OBJECT.findall(text)):
        try:
            value = json.loads(found).get("choice")
        except ValueError:
            continue
        if isinstance(value, str) or type(value) is int:
            return str(value)
    return None


def _as_key(said: str, keys: Sequence[str], options: Sequence[str]) -> str:
    """Return the key for a key or an option, else the text itself."""
    plain = _plain(said)
    by_option = {_plain(option): key for option, key in zip(options, keys, strict=False)}
    return plain if plain in keys else by_option.get(plain, said)


def _in_plain_text(text: str, keys: Sequence[str], options: Sequence[str]) -> list[str]:
    """Return what the text may mean: all of it, else its conclusions, else every key in it."""
    whole = _as_key(text, keys, options)
    if whole in keys:
        return [whole]
    lowered = text.lower()
    for conclusion in _CONCLUSIONS:
        if concluded := conclusion.findall(lowered):
            return concluded
    return [word for word in _WORD.findall(lowered) if word in keys]


def _only(said: Sequence[str], keys: Sequence[str]) -> str:
    distinct = sorted(set(said))
    if not distinct:
        raise UnusableReplyError("the reply names no choice")
    if len(distinct) > 1:
        raise UnusableReplyError(f"the reply names several choices: {', '.join(distinct):.60}")
    if distinct[0] not in keys:
        raise UnusableReplyError(f"the choice {distinct[0]!r:.40} is not in the list")
    return distinct[0]


def _plain(text: str) -> str:
    return text.strip(" \t\r\n.,;:!?\"'`*()[]").lower()
