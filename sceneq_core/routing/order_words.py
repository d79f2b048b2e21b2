"""The words that put things in an order: superlatives, ordinals and sides."""

SIZES = {
    "largest": "largest",
    "biggest": "largest",
    "smallest": "smallest",
    "tiniest": "smallest",
    "tallest": "tallest",
    "shortest": "shortest",
    "longest": "longest",
    "widest": "widest",
    "broadest": "widest",
    "narrowest": "narrowest",
    "highest": "highest",
    "topmost": "highest",
    "lowest": "lowest",
    "leftmost": "leftmost",
    "rightmost": "rightmost",
}
"""Superlatives that choose among several targets."""

SIZE_WORDS = {
    "small": ("volume", -1.0),
    "little": ("volume", -1.0),
    "tiny": ("volume", -1.0),
    "large": ("volume", 1.0),
    "big": ("volume", 1.0),
    "huge": ("volume", 1.0),
    "tall": ("height", 1.0),
    "low": ("height", -1.0),
    "long": ("length", 1.0),
    "wide": ("length", 1.0),
    "narrow": ("length", -1.0),
}
"""Word -> what it measures, and whether more or less of it fits better."""

ORDINALS = {
    word: rank
    for rank, names in enumerate(
        (
            ("first", "1st"),
            ("second", "2nd"),
            ("third", "3rd"),
            ("fourth", "4th"),
            ("fifth", "5th"),
            ("sixth", "6th"),
            ("seventh", "7th"),
            ("eighth", "8th"),
            ("ninth", "9th"),
            ("tenth", "10th"),
        ),
        start=1,
    )
    for word in names
}
"""Before a superlative, or with "from the left": which of the row."""

SIDE_NAMES = {
    "left": "leftmost",
    "left side": "leftmost",
    "right": "rightmost",
    "right side": "rightmost",
    "top": "highest",
    "bottom": "lowest",
    "me": "nearest",
    "here": "nearest",
    "front": "nearest",
    "back": "farthest",
}
"""Where an ordinal counts from."""

SIDES = {
    f"{lead} {far}{side}{ending}": relation
    for lead in ("on the", "to the", "at the")
    for far in ("", "far ")
    for side, relation in (("left", "leftmost"), ("right", "rightmost"))
    for ending in (" hand side", " side", "")
}
"""At the end: "the chair on the left"."""

CLOSEST = {
    "nearest": "nearest",
    "closest": "nearest",
    "farthest": "farthest",
    "furthest": "farthest",
}
AFTER_CLOSEST = ("to", "from")
"""Before the target: "the nearest chair" is nearest to the viewer, or to the anchor named later."""
