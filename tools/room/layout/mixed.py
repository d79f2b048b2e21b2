"""Mixed rooms: a large one to cook, eat, rest and work in."""

from sceneq_tools.room.layout.kitchen import ON_DINING_TABLE, ON_WORKTOPS, ROW
from sceneq_tools.room.layout.living_room import LOUNGE, MEDIA, ON_COFFEE_TABLE, ON_SHELVES
from sceneq_tools.room.layout.office import DESKTOP, WORKPLACE
from sceneq_tools.room.layout.plan import Near, Piece, Plan, Small

MIXED = Plan(
    kind="mixed",
    width_m=(6.6, 7.8),
    depth_m=(5.2, 6.2),
    windows=(2, 2),
    pictures=(3, 5),
    row=ROW,
    pieces=(
        LOUNGE,
        Piece("desk", "wall", front_m=0.9, near=(WORKPLACE,)),
        Piece("dining_table", "middle", front_m=0.6, near=(Near("chair", "around", (3, 6)),)),
        Piece("bookcase", "corner", (1, 2), front_m=0.5),
        Piece("dresser", "wall", (0, 1), front_m=0.5),
        Piece("filing_cabinet", "corner", (0, 1), front_m=0.4),
        Piece("plant", "corner", (2, 3), front_m=0.0),
    ),
    small=(
        *MEDIA,
        *DESKTOP,
        Small(("stove",), ("cooking pot",), (1, 1)),
        Small(("kitchen_cabinet",), ON_WORKTOPS, (3, 4)),
        Small(("dining_table",), ("bowl of fruit", "vase of flowers"), (1, 1), "centre"),
        Small(("dining_table",), ON_DINING_TABLE, (4, 6), "seats"),
        Small(("coffee_table",), ON_COFFEE_TABLE, (3, 4)),
        Small(("bookcase", "dresser"), ON_SHELVES, (4, 6)),
        Small(("nightstand",), ("table lamp", "alarm clock", "book"), (1, 2)),
        Small(
            ("sofa", "armchair"),
            ("backpack", "handbag", "teddy bear", "book", "folded clothes", "hat"),
            (1, 1),
        ),
        Small(
            ("desk", "coffee_table"),
            ("cardboard box", "slippers", "basketball", "sneakers", "trash can"),
            (1, 1), relation="under",
        ),
    ),
    floor=(
        "trash can", "suitcase", "cardboard box", "guitar", "fire extinguisher", "shopping basket",
        "basketball", "soccer ball", "backpack", "briefcase",
    ),
    floor_count=(3, 5),
    things=(70, 88),
    hung=("utensil rack", "wall clock", "cuckoo clock", "dartboard", "mirror"),
)  # fmt: skip
