"""The words a question is made of besides the thing it asks for: plain tables."""

OPENINGS = (
    "please",
    "hey",
    "ok",
    "can you",
    "could you",
    "would you",
    "tell me",
    "show me",
    "show",
    "find me",
    "find",
    "locate",
    "point to",
    "point at",
    "look for",
    "i am looking for",
    "i'm looking for",
    "i need",
    "i want",
    "get me",
    "bring me",
    "give me",
    "go to",
    "take me to",
    "where is",
    "where's",
    "where are",
    "where can i find",
    "where can i",
    "where could i",
    "where do i",
    "where do you see",
    "where",
    "what is",
    "what's",
    "what are",
    "what lies",
    "what stands",
    "which",
    "is there",
    "are there",
    "do you see",
    "do we have",
    "have you seen",
)
"""Ways to begin a question that say nothing about the thing."""

LINKS = ("that is", "that are", "which is", "which are", "is", "are", "that", "which", "located")
"""Ways to lead from a target to its relation."""

ENDINGS = ("please", "for me", "in here", "here", "there", *LINKS)

DETERMINERS = (
    "the",
    "a",
    "an",
    "any",
    "some",
    "my",
    "your",
    "our",
    "this",
    "that",
    "one of",
    "all",
)

ANYTHING = (
    "",
    "what",
    "anything",
    "something",
    "everything",
    "thing",
    "things",
    "object",
    "objects",
    "item",
    "items",
    "stuff",
    "one",
    "ones",
)
"""Targets that every instance satisfies."""

RELATIONS = {
    "next to": "next_to",
    "right next to": "next_to",
    "beside": "next_to",
    "adjacent to": "next_to",
    "against": "next_to",
    "by": "next_to",
    "near": "near",
    "near to": "near",
    "close to": "near",
    "around": "near",
    "nearest to": "nearest",
    "nearest": "nearest",
    "closest to": "nearest",
    "closest": "nearest",
    "farthest from": "farthest",
    "furthest from": "farthest",
    "on": "on",
    "on top of": "on",
    "upon": "on",
    "standing on": "on",
    "lying on": "on",
    "sitting on": "on",
    "hanging on": "on",
    "under": "under",
    "underneath": "under",
    "beneath": "under",
    "below": "under",
    "resting on": "on",
    "placed on": "on",
    "hung on": "on",
    "atop": "on",
    "alongside": "next_to",
    "touching": "next_to",
    "between": "between",
    "in between": "between",
    "supporting": "supports",
    "containing": "contains",
    "holding": "contains",
    "far from": "far_from",
    "far away from": "far_from",
    "above": "above",
    "over": "above",
    "left of": "left_of",
    "to the left of": "left_of",
    "on the left of": "left_of",
    "on the left side of": "left_of",
    "right of": "right_of",
    "to the right of": "right_of",
    "on the right of": "right_of",
    "on the right side of": "right_of",
    "in": "in",
    "inside": "in",
    "inside of": "in",
    "within": "in",
    "in front of": "in_front_of",
    "behind": "behind",
    "in back of": "behind",
}
"""Words between target and anchor -> relation; the longest match wins."""

HAVING = ("with", "having", "has", "have")
TURNED = {
    "on top of it": "supports",
    "on top of them": "supports",
    "on top": "supports",
    "on it": "supports",
    "on them": "supports",
    "inside it": "contains",
    "inside": "contains",
    "in it": "contains",
    "next to it": "next_to",
    "beside it": "next_to",
    "near it": "near",
    "above it": "under",
    "over it": "under",
    "under it": "above",
    "below it": "above",
    "behind it": "in_front_of",
    "in front of it": "behind",
}
"""Endings that say it the other way round: "the table with a lamp on it"."""

STANDPOINTS = {
    "facing": "facing",
    "when facing": "facing",
    "while facing": "facing",
    "if you face": "facing",
    "if you are facing": "facing",
    "looking at": "facing",
    "when looking at": "facing",
    "seen from": "seen_from",
    "as seen from": "seen_from",
    "viewed from": "seen_from",
    "looking from": "seen_from",
    "standing at": "seen_from",
}
"""Clauses, set off by a comma, that say where left and right are seen from."""

VIEW_WORDS = {
    "seen from": "seen_from",
    "as seen from": "seen_from",
    "viewed from": "seen_from",
    "when seen from": "seen_from",
    "when facing": "facing",
    "while facing": "facing",
    "if you face": "facing",
    "if you are facing": "facing",
}
"""The same, said between words."""

VIEWS = ("seen_from", "facing")

VIEWER = ("me", "us", "you", "myself", "yourself", "the viewer", "the robot", "the observer")
"""Anchors that mean where the scene is seen from."""

STRUCTURE = {
    "floor": "floor",
    "floors": "floor",
    "ground": "floor",
    "wall": "wall",
    "walls": "wall",
    "ceiling": "ceiling",
    "ceilings": "ceiling",
}
"""Words for parts of the building -> role of the instance; all other words mean objects."""

NO_ANCHORS = (
    "for",
    *(f"my {part}" for part in ("head", "face", "neck", "hand", "hands", "wrist", "feet", "foot")),
)
"""What follows a relation word that is part of a purpose: "something to wear on my feet"."""

PLACES = (
    "room",
    "scene",
    "house",
    "building",
    "apartment",
    "flat",
    "kitchen",
    "bathroom",
    "bedroom",
    "living room",
    "office",
    "hallway",
    "map",
    "view",
    "world",
)
"""Anchors that contain the whole scene: a relation to them says nothing."""
