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

SIZES = {
    "largest": "largest",
    "biggest": "largest",
    "smallest": "smallest",
    "tiniest": "smallest",
    "tallest": "tallest",
    "highest": "highest",
    "lowest": "lowest",
}
"""Superlatives that choose among several targets."""

CLOSEST = ("nearest", "closest")
AFTER_CLOSEST = {"to": "nearest", "from": "nearest"}
"""Before the target: "the nearest chair" is nearest to the viewer, or to the anchor named later."""

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
