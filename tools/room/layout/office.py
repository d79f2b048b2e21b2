"""Offices: desks with screens and chairs, shelves, cabinets, a printer."""

from sceneq_tools.room.layout.plan import Near, Piece, Plan, Small

WORKPLACE = Near("office_chair", "tucked")

ON_DESK = (
    "coffee mug", "coffee mug", "book", "book", "telephone", "pen holder", "scissors", "stapler",
    "calendar", "headphones", "camera", "tablet", "paper cup", "calculator", "picture frame",
    "newspaper", "cactus", "Rubik's cube", "cordless phone", "succulent", "letter tray", "fan",
    "glasses", "keys", "roll of tape", "drinking glass",
)  # fmt: skip

ON_OFFICE_SHELVES = (
    "book", "book", "book", "camera", "vase", "cactus", "radio", "speaker", "gift box",
    "picture frame", "alarm clock", "helmet", "Rubik's cube", "bonsai tree", "toy car",
    "telephone", "stapler", "coffee mug", "folded clothes", "hat",
)  # fmt: skip

DESKTOP = (
    Small(("desk",), ("laptop", "desktop computer"), (1, 1), "centre", straight=True),
    Small(("desk",), ("desk lamp",), (1, 1), "back"),
    Small(("desk",), ON_DESK, (4, 7)),
)

OFFICE = Plan(
    kind="office",
    width_m=(3.5, 4.8),
    depth_m=(3.4, 4.3),
    windows=(1, 2),
    pictures=(2, 4),
    row=None,
    pieces=(
        Piece("desk", "wall", front_m=0.9, near=(WORKPLACE,), needed=True),
        Piece("desk", "wall", (0, 1), front_m=0.9, near=(WORKPLACE,)),
        Piece("bookcase", "corner", (1, 2), front_m=0.5),
        Piece("filing_cabinet", "corner", (1, 2), front_m=0.4),
        Piece("dining_table", "middle", (0, 1), 0.5, near=(Near("chair", "around", (2, 4)),)),
        Piece("chest of drawers", "wall", (0, 1), front_m=0.4),
        Piece("whiteboard", "wall", (0, 1), front_m=0.6),
        Piece("water cooler", "corner", (0, 1), front_m=0.3),
        Piece("armchair", "corner", (0, 1), front_m=0.3),
        Piece("floor_lamp", "corner", (0, 1), front_m=0.0),
        Piece("plant", "corner", (1, 3), front_m=0.0),
    ),
    small=(
        *DESKTOP,
        Small(("filing_cabinet",), ("printer",), (1, 1)),
        Small(
            ("dining_table",),
            (
                "laptop", "coffee cup", "paper cup", "tray", "coffee maker", "newspaper", "tablet",
                "bowl of fruit", "birthday cake", "drinking glass", "glasses",
            ),
            (4, 6), "seats",
        ),
        Small(("bookcase",), ON_OFFICE_SHELVES, (6, 9)),
        Small(
            ("chest of drawers",),
            (
                "coffee maker", "coffee mug", "plastic cup", "plastic cup", "radio",
                "vase of flowers", "orchid", "printer", "espresso machine",
            ),
            (3, 5),
        ),
        Small(("filing_cabinet",), ("book", "cactus", "calendar", "fan", "succulent"), (0, 1)),
        Small(
            ("chair", "armchair"),
            ("backpack", "briefcase", "hat", "handbag", "book", "newspaper"),
            (0, 1),
        ),
        Small(
            ("desk",),
            ("trash can", "cardboard box", "backpack", "sneakers", "briefcase", "basketball"),
            (1, 1), relation="under",
        ),
    ),
    floor=(
        "trash can", "cardboard box", "cardboard box", "backpack", "briefcase", "fire extinguisher",
        "suitcase", "fan", "recycling bin",
    ),
    floor_count=(2, 4),
    things=(48, 66),
    hung=("wall clock", "cuckoo clock"),
    floors=("planks", "carpet"),
)  # fmt: skip
