"""What kind of answer a question wants: which one, where, how many, whether, when, or what."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

from sceneq_core.reasoning.relations import RELATIONS
from sceneq_core.routing import words
from sceneq_core.routing.attributes import COLOURS
from sceneq_core.routing.order_words import SIZE_WORDS
from sceneq_core.routing.phrase import MAX_CHARS, Phrase, read
from sceneq_core.routing.tokens import Tokens, drop_suffix, folded, match_at, tokens_of

FIND, WHERE, WHAT, COUNT, EXISTS, WHEN = "find", "where", "what", "count", "exists", "when"
PICTURE = "picture"
FORMS = (FIND, WHERE, WHAT, COUNT, EXISTS, WHEN, PICTURE)
"""``find``: which instance is meant; ``where``: the same, and its place in words; ``what``: all
that stands in a relation; ``count``; ``exists``: is there one; ``when``: when was it last seen;
``picture``: what looks like a picture, which no text is read as."""

MAX_PARTS = 4
"""More things than this are not asked for in one sentence."""

OPENINGS = {
    "how many": COUNT,
    "count": COUNT,
    "count all": COUNT,
    "count the": COUNT,
    "what is the number of": COUNT,
    "the number of": COUNT,
    "number of": COUNT,
    "is there": EXISTS,
    "are there": EXISTS,
    "do you see": EXISTS,
    "can you see": EXISTS,
    "do we have": EXISTS,
    "do you have": EXISTS,
    "have we got": EXISTS,
    "when did you last see": WHEN,
    "when did you see": WHEN,
    "when did you last saw": WHEN,
    "when have you seen": WHEN,
    "when have you last seen": WHEN,
    "when was": WHEN,
    "when were": WHEN,
    "how long ago did you see": WHEN,
    "how long ago did you last see": WHEN,
    "where did you last see": WHEN,
    "where did you see": WHEN,
    "last time you saw": WHEN,
    "where is": WHERE,
    "where's": WHERE,
    "where are": WHERE,
    "where was": WHERE,
    "where were": WHERE,
    "where can i find": WHERE,
}
"""What comes first and says the form; the longest match wins."""

ENDINGS = {
    COUNT: ("are there", "is there", "do you see", "can you see", "do we have", "do you have"),
    WHEN: ("last seen", "seen last", "seen", "last"),
}
"""What may come last in these forms."""

COUNT_LINKS = ("are there", "is there", "do you see", "can you see", "do we have", "are", "is")
"""Between what is counted and where: "how many cups are on the table"."""


@dataclass(frozen=True, slots=True)
class Form:
    """``kind`` is one of ``FORMS``; ``parts`` are the things asked for, one question each."""

    kind: str
    parts: tuple[str, ...]


def read_form(text: str) -> Form:
    """Return the form of the question ``text``.

    Raises:
        ValueError: no words in it, or too many characters.
    """
    if len(text) > MAX_CHARS:
        raise ValueError(f"question: {len(text)} characters, the limit is {MAX_CHARS}")
    polite = re.sub(r"^\W*(?:please|hey|ok|tell me|so)\b[\s,]*", "", folded(text))
    tokens = tokens_of(polite)
    behind = match_at(tokens, 0, OPENINGS)
    kind = OPENINGS[" ".join(tokens[:behind])] if behind else FIND
    if behind == len(tokens):
        read(text)
        return Form(FIND, (text,))
    parts = tuple(part.strip() for part in _parts(_rest(polite, behind)))
    if kind in (COUNT, WHEN):
        parts = tuple(_trimmed(part, kind) for part in parts)
    if len(parts) < 2 and kind not in (COUNT, WHEN):
        parts = (text,)
    phrases = [read(part) for part in parts]
    if kind == FIND and all(_is_open(phrase) for phrase in phrases):
        kind = WHAT
    return Form(kind, parts)


def _is_open(phrase: Phrase) -> bool:
    """Whether anything is asked for that stands in a relation to something."""
    return not phrase.target and any(
        c.anchor and c.relation in (*RELATIONS, "between") for c in phrase.constraints
    )


def _rest(text: str, count: int) -> str:
    """Return ``text`` without its first ``count`` words, commas kept."""
    rest = text
    while count:
        word, rest = re.match(r"\W*(\S+)(.*)", rest, re.DOTALL).groups()  # type: ignore[union-attr]
        count -= len(tokens_of(word))
    return rest


def _trimmed(part: str, kind: str) -> str:
    """Return a part without what only the form needs; never nothing."""
    tokens = tokens_of(part)
    shorter = drop_suffix(tokens, ENDINGS[kind]) or tokens
    if kind == COUNT:
        shorter = _without_link(shorter)
    return " ".join(shorter)


def _without_link(tokens: Tokens) -> Tokens:
    for at in range(1, len(tokens)):
        behind = match_at(tokens, at, COUNT_LINKS)
        if behind and match_at(tokens, behind, (*words.RELATIONS, "not")):
            return (*tokens[:at], *tokens[behind:])
    return tokens


def _parts(text: str) -> Iterable[str]:
    """Yield the things that are asked for, at most ``MAX_PARTS``: "the mug and the plate".

    "and" also joins colours, anchors of "between" and relations; then it separates nothing.
    """
    clauses = re.split(r",\s", text)
    if any(match_at(tokens_of(clause), 0, words.STANDPOINTS) for clause in clauses):
        yield text
        return
    pieces = [piece for clause in clauses for piece in _pieces(clause)]
    if not 2 <= len(pieces) <= MAX_PARTS or not all(map(_is_thing, pieces)):
        yield text
        return
    yield from pieces


def _pieces(clause: str) -> list[str]:
    pieces: list[str] = []
    for piece in re.split(r"\band\b", clause):
        before = tokens_of(pieces[-1]) if pieces else ()
        if pieces and (_is_open_between(before) or _belong(before, tokens_of(piece))):
            pieces[-1] = f"{pieces[-1]}and{piece}"
        elif piece.strip():
            pieces.append(piece)
    return pieces


def _is_open_between(tokens: Tokens) -> bool:
    return "between" in tokens and "and" not in tokens[tokens.index("between") :]


def _belong(before: Tokens, behind: Tokens) -> bool:
    """Whether "and" joins two attributes, or a second relation of the same thing."""
    if not before or not behind:
        return True
    attributes = {*COLOURS, *SIZE_WORDS}
    if before[-1] in attributes and behind[0] in attributes:
        return True
    return bool(match_at(behind, 0, (*words.RELATIONS, "not", "is", "are", "that")))


def _is_thing(piece: str) -> bool:
    try:
        return bool(read(piece).target)
    except ValueError:
        return False
