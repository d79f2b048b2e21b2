"""The words of a question, and how tables of phrases match them."""

import unicodedata
from collections.abc import Iterable, Sequence

Tokens = tuple[str, ...]

_PUNCTUATION = '?!.,;:"“”„«»()[]{}<>¿¡'
_CONTRACTED = {"isn't": "is not", "aren't": "are not", "there's": "there is", "'s": ""}


def folded(text: str) -> str:
    """Return lower case text of printable characters, in one way of writing."""
    plain = unicodedata.normalize("NFKC", text).replace("’", "'").lower()
    return "".join(c if c.isprintable() else " " for c in plain)


def tokens_of(text: str) -> Tokens:
    """Return the words of ``text`` without punctuation around them."""
    stripped = (token.strip(_PUNCTUATION) for token in folded(text).split())
    spelled = (_CONTRACTED.get(token, token).split() for token in stripped)
    return tuple(token for tokens in spelled for token in tokens)


def drop_prefix(tokens: Tokens, phrases: Iterable[str]) -> Tokens:
    """Return ``tokens`` without the longest of the phrases that they begin with."""
    end = match_at(tokens, 0, phrases)
    return tokens[end:] if end else tokens


def drop_suffix(tokens: Tokens, phrases: Sequence[str]) -> Tokens:
    """Return ``tokens`` without the first of the phrases that they end with."""
    ending = suffix(tokens, phrases)
    return tokens[: -len(ending.split())] if ending else tokens


def suffix(tokens: Tokens, phrases: Iterable[str]) -> str:
    """Return the first of the phrases that ``tokens`` end with, "" = none."""
    for phrase in phrases:
        part = tuple(phrase.split())
        if tokens[-len(part) :] == part:
            return phrase
    return ""


def match_at(tokens: Tokens, at: int, phrases: Iterable[str]) -> int:
    """Return the end of the longest phrase that starts at ``at``, 0 = none."""
    lengths = (len(phrase.split()) for phrase in phrases if _starts(tokens, at, phrase))
    longest = max(lengths, default=0)
    return at + longest if longest else 0


def take(tokens: Tokens, wanted: Iterable[str]) -> tuple[Tokens, Tokens]:
    """Return the tokens without the wanted words, and those words."""
    known = frozenset(wanted)
    return tuple(t for t in tokens if t not in known), tuple(t for t in tokens if t in known)


def _starts(tokens: Tokens, at: int, phrase: str) -> bool:
    part = tuple(phrase.split())
    return tokens[at : at + len(part)] == part
