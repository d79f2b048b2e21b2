"""Bedrooms: a bed with its head at the wall, nightstands, a wardrobe, clothes and toys."""

from sceneq_tools.room.layout.living_room import ON_SHELVES
from sceneq_tools.room.layout.office import DESKTOP
from sceneq_tools.room.layout.plan import Near, Piece, Plan, Small

BEDROOM = Plan(
    kind="bedroom",
    width_m=(3.9, 5.2),
    depth_m=(3.7, 4.6),
    windows=(1, 2),
    pictures=(2, 4),
    row=None,
    pieces=(
        Piece(
            "bed",
            "centre",
            front_m=0.5,
            near=(Near("nightstand", "beside", (1, 2), gap_m=0.06), Near("rug", "beneath")),
            needed=True,
        ),
        Piece("wardrobe", "corner", front_m=0.6),
        Piece("dresser", "wall", (1, 2), front_m=0.5),
        Piece("desk", "wall", (0, 1), front_m=0.8, near=(Near("office_chair", "tucked"),)),
        Piece("bookcase", "corner", (0, 1), front_m=0.4),
        Piece("armchair", "corner", (0, 1), front_m=0.3),
        Piece("floor_lamp", "corner", (0, 1), front_m=0.0),
        Piece("stool", "wall", (0, 1), front_m=0.0),
        Piece("plant", "corner", (1, 2), front_m=0.0),
    ),
    small=(
        Small(("nightstand",), ("table lamp",), (1, 1), "back"),
        Small(
            ("nightstand",),
            (
                "alarm clock", "book", "coffee mug", "cordless phone", "candle", "drinking glass",
                "glasses", "wristwatch",
            ),
            (1, 3),
        ),
        Small(
            ("bed",),
            (
                "teddy bear", "book", "folded clothes", "tablet", "hat", "headphones", "handbag",
                "newspaper", "game controller", "doll", "towel",
            ),
            (3, 5),
        ),
        *DESKTOP,
        Small(("chest of drawers",), ("television",), (0, 1), "back", straight=True),
        Small(
            ("dresser",),
            (
                "picture frame", "vase", "handbag", "orchid", "radio", "fan", "gift box",
                "vase of flowers", "hat", "folded clothes", "candle", "camera", "cap", "book",
                "towel",
            ),
            (4, 6),
        ),
        Small(("bookcase",), ON_SHELVES, (5, 8)),
        Small(
            ("chair", "armchair", "stool"),
            ("folded clothes", "backpack", "hat", "handbag"),
            (0, 1),
        ),
        Small(("wardrobe",), ("suitcase", "cardboard box", "gift box"), (0, 1)),
        Small(
            ("bed", "desk"),
            (
                "slippers", "cardboard box", "suitcase", "sneakers", "basketball", "toy car",
                "gift box",
            ),
            (1, 2), relation="under",
        ),
    ),
    floor=(
        "suitcase", "backpack", "slippers", "sneakers", "guitar", "basketball", "soccer ball",
        "laundry basket", "trash can", "cardboard box", "boots", "high heels", "bean bag",
        "doll house",
    ),
    floor_count=(3, 5),
    things=(45, 62),
    hung=("wall clock", "cuckoo clock", "mirror"),
    floors=("planks", "carpet"),
)  # fmt: skip
