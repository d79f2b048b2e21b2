"""What a question asks for: target, colours, size and relations to anchors.

A table-driven reader of short English questions. Text it does not understand stays part of the
target, which the encoder then sees whole: reading too little is safe, reading too much is not.
"""

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from sceneq_core.encoding.colour import split_colours
from sceneq_core.reasoning.reasoner import Constraint
from sceneq_core.routing import words

MAX_CHARS = 1000
MAX_RELATIONS = 3
_PUNCTUATION = '?!.,;:"“”„«»()[]{}<>¿¡'

Tokens = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Phrase:
    """A question, read.

    ``target`` are the words for the encoder, "" = anything. All ``constraints`` must hold; any
    makes the question spatial: then geometry is needed to answer.
    """

    target: str
    constraints: tuple[Constraint, ...]


def read(text: str) -> Phrase:
    """Return what ``text`` asks for.

    Raises:
        ValueError: nothing but white space, or more than ``MAX_CHARS`` characters.
    """
    if len(text) > MAX_CHARS:
        raise ValueError(f"question: {len(text)} characters, the limit is {MAX_CHARS}")
    tokens = _strip_frame(_tokens(text))
    if not tokens:
        raise ValueError("question: no words in it")
    if tokens[0] in words.CLOSEST:
        target, relations = _read_closest(tokens[1:])
    else:
        target, relations = _split_relations(tokens, words.RELATIONS)
    target, sizes = _take(_strip_target(target), words.SIZES)
    comparing = tuple(Constraint(words.SIZES[size], "") for size in sizes[:1])
    return Phrase(_name(target), (*relations[:MAX_RELATIONS], *comparing))


def without_colours(text: str) -> tuple[str, tuple[int, ...]]:
    """Return a target or anchor without its colour words, and the rows of ``COLOUR_TERMS``."""
    rest, shares = split_colours(text)
    rows = tuple(int(row) for row in np.flatnonzero(shares))
    return _name(tuple(rest.split())), rows


def _tokens(text: str) -> Tokens:
    folded = unicodedata.normalize("NFKC", text).replace("’", "'").lower()
    printable = "".join(c if c.isprintable() else " " for c in folded)
    stripped = (token.strip(_PUNCTUATION) for token in printable.split())
    return tuple(token for token in stripped if token)


def _strip_frame(tokens: Tokens) -> Tokens:
    """Drop openings, determiners and endings, again and again, but never everything."""
    while True:
        shorter = _drop_prefix(tokens, words.OPENINGS + words.DETERMINERS)
        shorter = _drop_suffix(shorter, words.ENDINGS)
        if shorter == tokens or not shorter:
            return tokens
        tokens = shorter


def _strip_target(tokens: Tokens) -> Tokens:
    """Drop what leads up to a relation: "the cup that is", "which chair is"."""
    shorter = _drop_suffix(_drop_prefix(tokens, words.DETERMINERS), words.LINKS)
    return tokens if shorter == tokens else _strip_target(shorter)


def _name(tokens: Tokens) -> str:
    text = " ".join(tokens)
    return "" if text in words.ANYTHING else text


def _read_closest(tokens: Tokens) -> tuple[Tokens, tuple[Constraint, ...]]:
    """Read the rest of "the nearest chair to the door" and of "the nearest chair"."""
    table = words.RELATIONS | words.AFTER_CLOSEST
    target, relations = _split_relations(tokens, table)
    if any(relation.relation == "nearest" for relation in relations):
        return target, relations
    return target, (Constraint("nearest", ""), *relations)


def _split_relations(
    tokens: Tokens, table: Mapping[str, str]
) -> tuple[Tokens, tuple[Constraint, ...]]:
    """Cut at every relation that has an anchor behind it."""
    cuts = list(_cuts(tokens, table))
    if not cuts:
        return tokens, ()
    ends = [start for start, _, _ in cuts[1:]] + [len(tokens)]
    relations = [
        _relation(name, tokens[behind:end])
        for (_, behind, name), end in zip(cuts, ends, strict=True)
    ]
    return tokens[: cuts[0][0]], tuple(r for r in relations if r is not None)


def _cuts(tokens: Tokens, table: Mapping[str, str]) -> Iterable[tuple[int, int, str]]:
    """Yield (start, end, relation) of the relation words that something follows."""
    at = 0
    while at < len(tokens):
        end = _match_at(tokens, at, table)
        if 0 < end < len(tokens):
            yield at, end, table[" ".join(tokens[at:end])]
        at = max(end, at + 1)


def _relation(name: str, anchor: Tokens) -> Constraint | None:
    text = " ".join(anchor)
    if text in words.VIEWER:
        return Constraint(name, "")
    noun = " ".join(_strip_target(anchor))
    return None if noun in words.PLACES or not noun else Constraint(name, noun)


def _take(tokens: Tokens, wanted: Iterable[str]) -> tuple[Tokens, Tokens]:
    """Return the tokens without the wanted words, and those words."""
    known = frozenset(wanted)
    return tuple(t for t in tokens if t not in known), tuple(t for t in tokens if t in known)


def _drop_prefix(tokens: Tokens, phrases: Sequence[str]) -> Tokens:
    end = _match_at(tokens, 0, phrases)
    return tokens[end:] if end else tokens


def _drop_suffix(tokens: Tokens, phrases: Sequence[str]) -> Tokens:
    for phrase in phrases:
        part = tuple(phrase.split())
        if tokens[-len(part) :] == part:
            return tokens[: -len(part)]
    return tokens


def _match_at(tokens: Tokens, at: int, phrases: Iterable[str]) -> int:
    """Return the end of the longest phrase that starts at ``at``, 0 = none."""
    lengths = (len(phrase.split()) for phrase in phrases if _starts(tokens, at, phrase))
    longest = max(lengths, default=0)
    return at + longest if longest else 0


def _starts(tokens: Tokens, at: int, phrase: str) -> bool:
    part = tuple(phrase.split())
    return tokens[at : at + len(part)] == part
