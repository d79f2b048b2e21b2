"""Names as people write them, and as questions speak them."""

import unicodedata

from sceneq_core.routing import forms, phrase

INDIVIDUAL, CATEGORY = "individual", "category"
KINDS = (INDIVIDUAL, CATEGORY)
"""``individual``: this one thing only, such as "aunt Mary's mug"; ``category``: this thing and all
that are like it, such as "espresso machine"."""

MAX_NAME_CHARS = 64
POSSESSIVES = ("my", "your", "our", "his", "her", "their")
_ARTICLES = ("the", "a", "an")
_MARKS = '?!.,;:"“”„«»()[]{}<>¿¡'


def clean(text: str, what: str = "name") -> str:
    """Return ``text`` in normal form, white space collapsed.

    Raises:
        ValueError: nothing in it, too long, or with control characters; ``what`` is named.
    """
    if len(text) > 4 * MAX_NAME_CHARS:
        raise ValueError(f"{what}: {len(text)} characters, the limit is {MAX_NAME_CHARS}")
    if any(unicodedata.category(char)[0] == "C" for char in text):
        raise ValueError(f"{what}: control characters in {text!r:.80}")
    tidy = " ".join(unicodedata.normalize("NFC", text).split())
    if not any(char.isalnum() for char in tidy):
        raise ValueError(f"{what}: no letter or digit in {text!r:.80}")
    if len(tidy) > MAX_NAME_CHARS:
        raise ValueError(f"{what}: {len(tidy)} characters, the limit is {MAX_NAME_CHARS}")
    return tidy


def clean_name(text: str) -> str:
    """Return a name that questions can speak, without its article.

    Raises:
        ValueError: as ``clean``, or one that reads as more or less than one thing.
    """
    name = clean(text)
    first, _, rest = name.partition(" ")
    name = rest if first.lower() in _ARTICLES and rest else name
    if len(forms.read_form(f"where is {name}").parts) > 1:
        raise ValueError(f"name: {name!r} reads as several things: use other words")
    read = phrase.read(name)
    if read.constraints:
        relation = read.constraints[0].relation.replace("_", " ")
        raise ValueError(f"name: {name!r} reads as a relation ({relation!r}): use other words")
    if not read.target or phrase.read(f"where is {name}") != read:
        raise ValueError(f"name: {name!r} could be anything to a question: use other words")
    return name


def thing_of(name: str) -> str:
    """Return what a question that speaks a (clean) name asks for."""
    return phrase.read(name).target


def spoken(text: str) -> str:
    """Return the words of ``text`` as they are compared: no case, no marks, one apostrophe."""
    folded = unicodedata.normalize("NFKC", text).replace("’", "'").lower()
    return " ".join(word for word in (part.strip(_MARKS) for part in folded.split()) if word)


def speaks(text: str, name: str) -> bool:
    """Whether all words of ``name`` are in ``text``, in its order: "the mug" is not "my mug"."""
    return f" {spoken(name)} " in f" {spoken(text)} "


def kind_of(name: str) -> str:
    """Return the kind that a name is of unless somebody says otherwise.

    A name is that of an individual when one of its words is a possessive ("Mary's", "my"), starts
    with a capital letter without being all capitals ("Excalibur", but not "TV"), or has a digit
    ("locker 12"). All others are names of categories.
    """
    return INDIVIDUAL if any(_is_proper(word) for word in name.split()) else CATEGORY


def _is_proper(word: str) -> bool:
    bare = spoken(word)
    possessive = bare.endswith(("'s", "s'")) or bare in POSSESSIVES
    capital = word[:1].isupper() and not (len(word) > 1 and word.isupper())
    return possessive or capital or any(char.isdigit() for char in word)
