"""What a question asks for: target, colours, size and relations to anchors.

A table-driven reader of short English questions. Text it does not understand stays part of the
target, which the encoder then sees whole: reading too little is safe, reading too much is not.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from sceneq_core.encoding.colour import split_colours
from sceneq_core.reasoning.english import singular
from sceneq_core.reasoning.reasoner import Constraint
from sceneq_core.reasoning.relations import VIEWER_RELATIVE
from sceneq_core.reasoning.superlatives import SIDEWAYS
from sceneq_core.routing import order_words, words
from sceneq_core.routing.attributes import plain_attributes
from sceneq_core.routing.tokens import (
    Tokens,
    drop_prefix,
    drop_suffix,
    match_at,
    suffix,
    take,
    tokens_of,
)

MAX_CHARS = 1000
MAX_RELATIONS = 3

RELATIONS = {**words.RELATIONS, **words.VIEW_WORDS}


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
    tokens, view = _standpoint(text)
    tokens = _strip_frame(tokens)
    if not tokens:
        raise ValueError("question: no words in it")
    target, constraints = _read_order(tokens)
    target = plain_attributes(_strip_target(target))
    return Phrase(_name(target), _seen(constraints, view))


def without_colours(text: str) -> tuple[str, tuple[int, ...]]:
    """Return a target or anchor without its colour words, and the rows of ``COLOUR_TERMS``."""
    rest, shares = split_colours(text)
    rows = tuple(int(row) for row in np.flatnonzero(shares))
    return _name(tuple(rest.split())), rows


def without_sizes(thing: str) -> tuple[str, tuple[str, ...]]:
    """Return a thing without the size words it begins with, and these; never nothing at all."""
    tokens = thing.split(" ")
    count = next((i for i, token in enumerate(tokens) if token not in order_words.SIZE_WORDS), 0)
    return _name(tuple(tokens[count:])), tuple(tokens[:count])


def _standpoint(text: str) -> tuple[Tokens, Constraint | None]:
    """Cut off a clause such as "facing the window, ..." and return it as a constraint."""
    clauses = [tokens_of(clause) for clause in re.split(r",\s", text)]
    for i, clause in enumerate(clauses):
        behind = match_at(clause, 0, words.STANDPOINTS)
        others = tuple(token for j, one in enumerate(clauses) if j != i for token in one)
        if behind and others:
            view = _relation(words.STANDPOINTS[" ".join(clause[:behind])], clause[behind:])
            if view is not None and view.anchor:
                return others, view
    return tuple(token for clause in clauses for token in clause), None


def _seen(constraints: tuple[Constraint, ...], view: Constraint | None) -> tuple[Constraint, ...]:
    """Say of left and right where they are seen from; that alone is no relation."""
    views = [c for c in constraints if c.relation in words.VIEWS]
    kept = tuple(c for c in constraints if c.relation not in words.VIEWS)
    view = view or (views[0] if views else None)
    if view is None or not view.anchor:
        return kept
    seen_from = view.anchor if view.relation == "seen_from" else ""
    facing = view.anchor if view.relation == "facing" else ""
    return tuple(
        replace(c, seen_from=seen_from, facing=facing)
        if c.relation in VIEWER_RELATIVE or c.relation in SIDEWAYS
        else c
        for c in kept
    )


def _strip_frame(tokens: Tokens) -> Tokens:
    """Drop openings, determiners and endings, again and again, but never everything."""
    while True:
        shorter = drop_prefix(tokens, words.OPENINGS + words.DETERMINERS)
        shorter = drop_suffix(shorter, words.ENDINGS)
        if shorter == tokens or not shorter:
            return tokens
        tokens = shorter


def _strip_target(tokens: Tokens) -> Tokens:
    """Drop what leads up to a relation: "the cup that is", "which chair is"."""
    shorter = drop_suffix(drop_prefix(tokens, words.DETERMINERS), words.LINKS)
    return tokens if shorter == tokens else _strip_target(shorter)


def _name(tokens: Tokens) -> str:
    text = " ".join(tokens)
    return "" if text in words.ANYTHING else text


def _read_order(tokens: Tokens) -> tuple[Tokens, tuple[Constraint, ...]]:
    """Read ordinals and superlatives, and the relations they leave."""
    rank = order_words.ORDINALS.get(tokens[0], 1)
    rest = tokens[1:] if rank > 1 or tokens[0] in order_words.ORDINALS else tokens
    if rest and rest[0] in order_words.CLOSEST:
        return _read_closest(rest[1:], order_words.CLOSEST[rest[0]], rank)
    if rest != tokens and (counted := _read_counted(rest, rank)):
        return counted
    side = suffix(tokens, order_words.SIDES)
    if side and len(tokens) > len(side.split()):
        target, relations = _read_relations(tokens[: -len(side.split())])
        return target, (*relations, Constraint(order_words.SIDES[side], ""))
    target, relations = _read_relations(tokens)
    _, sizes = take(target[:2] if rest != tokens else target, order_words.SIZES)
    if not sizes:
        return target, relations
    target, _ = take(target, order_words.SIZES)
    target = target[1:] if rest != tokens and target[:1] == tokens[:1] else target
    return target, (*relations, Constraint(order_words.SIZES[sizes[0]], "", rank=rank))


def _read_counted(tokens: Tokens, rank: int) -> tuple[Tokens, tuple[Constraint, ...]] | None:
    """Read what follows "second" in "second chair from the left", or from any other thing."""
    if "from" not in tokens[1:-1]:
        return None
    at = len(tokens) - 1 - tokens[::-1].index("from")
    anchor = _strip_target(tokens[at + 1 :])
    target, relations = _read_relations(tokens[:at])
    relation = order_words.SIDE_NAMES.get(" ".join(anchor))
    if relation:
        return target, (*relations, Constraint(relation, "", rank=rank))
    nearest = _relation("nearest", anchor)
    return (target, (*relations, replace(nearest, rank=rank))) if nearest else None


def _read_closest(tokens: Tokens, name: str, rank: int) -> tuple[Tokens, tuple[Constraint, ...]]:
    """Read the rest of "the nearest chair to the door" and of "the nearest chair"."""
    table = {**RELATIONS, **dict.fromkeys(order_words.AFTER_CLOSEST, name)}
    target, relations = _split_relations(tokens, table)
    if any(relation.relation == name for relation in relations):
        ranked = (replace(r, rank=rank) if r.relation == name else r for r in relations)
        return target, tuple(ranked)
    return target, (Constraint(name, "", rank=rank), *relations)


def _read_relations(tokens: Tokens) -> tuple[Tokens, tuple[Constraint, ...]]:
    """Read "the table with a lamp on it", else every relation that has an anchor behind it."""
    turned = suffix(tokens, words.TURNED)
    kept = tokens[: -len(turned.split())] if turned else ()
    at = next((i for i, token in enumerate(kept) if token in words.HAVING and i), 0)
    anchor = _relation(words.TURNED[turned], kept[at + 1 :]) if at else None
    if anchor is None:
        return _split_relations(tokens, RELATIONS)
    target, relations = _split_relations(kept[:at], RELATIONS)
    return target, (*relations, anchor)


def _split_relations(
    tokens: Tokens, table: Mapping[str, str]
) -> tuple[Tokens, tuple[Constraint, ...]]:
    """Cut at every relation that has an anchor behind it."""
    cuts = list(_cuts(tokens, table))
    if not cuts:
        return tokens, ()
    ends = [start for start, _, _ in cuts[1:]] + [len(tokens)]
    relations = []
    for (start, behind, name), end in zip(cuts, ends, strict=True):
        relation = _relation(name, tokens[behind:end])
        if relation is not None:
            relations.append(replace(relation, negated=tokens[start - 1 : start] == ("not",)))
    return drop_suffix(tokens[: cuts[0][0]], ("not",)), tuple(relations[:MAX_RELATIONS])


def _cuts(tokens: Tokens, table: Mapping[str, str]) -> Iterable[tuple[int, int, str]]:
    """Yield (start, end, relation) of the relation words that something follows."""
    at = 0
    while at < len(tokens):
        end = match_at(tokens, at, table)
        name = table.get(" ".join(tokens[at:end]), "")
        leads_to_anchor = 0 < end < len(tokens) and not match_at(tokens, end, words.NO_ANCHORS)
        if leads_to_anchor and (at or name not in words.VIEWS):
            yield at, end, name
        at = max(end, at + 1)


def _relation(name: str, anchor: Tokens) -> Constraint | None:
    anchor = drop_suffix(drop_suffix(anchor, ("not",)), ("and", "but"))
    text = " ".join(anchor)
    if text in words.VIEWER:
        return Constraint(name, "")
    if name == "between":
        return _between(anchor)
    noun = _noun(anchor)
    return None if noun in words.PLACES or not noun else Constraint(name, noun)


def _between(anchor: Tokens) -> Constraint | None:
    """Read "the sofa and the table", or "the windows": two of the same."""
    if "and" not in anchor:
        noun = singular(_noun(drop_prefix(anchor, ("the two", "both the", "both", "two"))))
        return Constraint("between", noun, noun) if noun else None
    at = anchor.index("and")
    one, other = _noun(anchor[:at]), _noun(anchor[at + 1 :])
    return Constraint("between", one, other) if one and other else None


def _noun(tokens: Tokens) -> str:
    return " ".join(plain_attributes(_strip_target(tokens)))
