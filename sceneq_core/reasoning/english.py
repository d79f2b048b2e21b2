"""Small pieces of plain English: plurals, lists and lengths."""

from collections.abc import Sequence

IRREGULAR = {
    "person": "people",
    "man": "men",
    "woman": "women",
    "child": "children",
    "knife": "knives",
    "shelf": "shelves",
    "bookshelf": "bookshelves",
    "loaf": "loaves",
    "leaf": "leaves",
    "foot": "feet",
    "mouse": "mice",
}
NO_PLURAL = frozenset({"stairs", "blinds", "scissors", "clothes", "headphones", "stuff"})
"""Names of one thing that end like a plural, and of what is not counted."""
SIBILANTS = ("s", "x", "z", "ch", "sh")

NO_ENDING = ("ss", "us", "is", *"abcdefghijklmnopqrtuvwxyz0123456789")
_SINGULAR = {many: one for one, many in IRREGULAR.items()}


RELATION_WORDS = {"supports": "supporting", "contains": "containing"}


def relation_words(relation: str) -> str:
    """Return how a relation is said between a thing and its anchor."""
    return RELATION_WORDS.get(relation, relation.replace("_", " "))


def plural(noun: str) -> str:
    """Return the plural of a noun phrase: its last word changes."""
    head, _, last = noun.rpartition(" ")
    if not last or last in NO_PLURAL:
        return noun
    if last in IRREGULAR:
        many = IRREGULAR[last]
    elif last.endswith(SIBILANTS):
        many = f"{last}es"
    elif last.endswith("y") and last[-2:-1] not in tuple("aeiou"):
        many = f"{last[:-1]}ies"
    else:
        many = f"{last}s"
    return f"{head} {many}".strip()


def singular(noun: str) -> str:
    """Return the singular of a noun phrase; a noun that is no plural stays as it is."""
    head, _, last = noun.rpartition(" ")
    if last in _SINGULAR:
        one = _SINGULAR[last]
    elif last in NO_PLURAL or len(last) < 4 or last.endswith(NO_ENDING):
        one = last
    elif last.endswith("ies"):
        one = f"{last[:-3]}y"
    elif last.endswith(("ches", "shes", "xes", "zes", "sses")):
        one = last[:-2]
    else:
        one = last[:-1]
    return f"{head} {one}".strip()


def counted(count: int, noun: str) -> str:
    """Return such as "1 mug", "3 mugs" or "no mug"."""
    if count == 0:
        return f"no {noun}"
    return f"{count} {noun if count == 1 else plural(noun)}"


def listed(parts: Sequence[str], last: str = "and") -> str:
    """Return such as "a", "a and b" or "a, b and c"."""
    if len(parts) < 2:
        return "".join(parts)
    return f"{', '.join(parts[:-1])} {last} {parts[-1]}"


def metres(length_m: float) -> str:
    """Return a length with the digits that a map of some centimetres can vouch for."""
    return f"{length_m:.2f} m" if length_m < 1 else f"{length_m:.1f} m"


def ordinal(rank: int) -> str:
    """Return such as "2nd"."""
    teen = 10 <= rank % 100 <= 20
    ending = "th" if teen else {1: "st", 2: "nd", 3: "rd"}.get(rank % 10, "th")
    return f"{rank}{ending}"
