"""Does somebody name a thing, or describe it: by what it is for, what it does, what it is made of?

Words that describe are far from every name, whether there is such a thing or not, so that what
the encoder says of them means something else.
"""

from sceneq_core.routing.tokens import Tokens, drop_prefix, match_at, tokens_of

POLITE = ("please", "hey", "ok", "so", "tell me", "show me")

ANY = (
    "something",
    "anything",
    "somewhere",
    "anywhere",
    "someplace",
    "a place",
    "place",
    "a thing",
    "thing",
    "things",
    "a spot",
    "spot",
)
"""Words for anything, which what follows describes."""

DOING = (
    "where can i",
    "where can we",
    "where could i",
    "where could we",
    "where do i",
    "where do we",
    "where should i",
    "what can i",
    "what could i",
)
"""Openings that a verb follows: what somebody wants to do."""

FINDING = ("find", "see", "get")
"""Verbs that say nothing about the thing: "where can I find the mug"."""

CLAUSES = ("to", "that")
"""What begins a description behind a noun: "an instrument to play music on"."""


def wants_to_do(text: str) -> bool:
    """Return whether a question says what somebody wants to do: "where can I wash my hands"."""
    tokens = drop_prefix(tokens_of(text), POLITE)
    behind = match_at(tokens, 0, DOING)
    return 0 < behind < len(tokens) and tokens[behind] not in FINDING


def describes(thing: str) -> bool:
    """Return whether the words for a thing describe it: "something to sit on"."""
    tokens: Tokens = tuple(thing.split())
    behind = match_at(tokens, 0, ANY)
    return 0 < behind < len(tokens) or any(token in CLAUSES for token in tokens[1:-1])
