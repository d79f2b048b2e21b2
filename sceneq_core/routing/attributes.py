"""Attributes said after the noun, negated, or of size."""

from sceneq_core.encoding.colour import COLOUR_TERMS, SAME_AS, SHADES
from sceneq_core.routing.tokens import Tokens, match_at

LINKS = ("that is", "that are", "which is", "which are", "that's", "is", "are")

COLOURS = frozenset({*COLOUR_TERMS, *SAME_AS})


def plain_attributes(tokens: Tokens) -> Tokens:
    """Return "red chair" for "chair that is red" and "chair not red" for "chair that is not red".

    What is said of it otherwise stays as it is.
    """
    for at in range(1, len(tokens)):
        behind = match_at(tokens, at, LINKS)
        said = tokens[behind:]
        if not behind or not said:
            continue
        if said[0] == "not" and _is_colour(said[1:]):
            return (*tokens[:at], *said)
        if _is_colour(said):
            return (*said, *tokens[:at])
    return tokens


def without_excluded(thing: str) -> tuple[str, tuple[int, ...]]:
    """Return the words for a thing without "not red", and the excluded rows of ``COLOUR_TERMS``."""
    tokens = thing.replace("non-", "not ").split()
    rows: list[int] = []
    for at in reversed([i for i, token in enumerate(tokens) if token == "not"]):
        end = at + 2 if tokens[at + 1 : at + 2] and tokens[at + 1] in SHADES else at + 1
        if end < len(tokens) and tokens[end] in COLOURS:
            colour = SAME_AS.get(tokens[end], tokens[end])
            rows.append(COLOUR_TERMS.index(colour))
            del tokens[at : end + 1]
    return " ".join(tokens), tuple(sorted(rows))


def _is_colour(tokens: Tokens) -> bool:
    return bool(tokens) and all(t in COLOURS or t in SHADES or t == "and" for t in tokens)
