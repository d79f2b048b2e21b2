"""Mixed rooms: a large one to cook, eat, rest and work in."""

from sceneq_tools.room.layout.kitchen import ON_DINING_TABLE, ON_WORKTOPS, ROW
from sceneq_tools.room.layout.living_room import LOUNGE, MEDIA, ON_COFFEE_TABLE, ON_SHELVES
from sceneq_tools.room.layout.office import DESKTOP, WORKPLACE
from sceneq_tools.room.layout.plan import Near, Piece, Plan, Small

AT_TABLE = (Near("rug", "beneath", (0, 1)), Near("chair", "around", (3, 6)))

MIXED = Plan(
    kind="mixed",
    width_m=(6.0, 7.2),
    depth_m=(4.9, 5.8),
    windows=(2, 2),
    pictures=(3, 5),
    row=ROW,
    pieces=(
        LOUNGE,
        Piece("desk", "wall", front_m=0.9, near=(WORKPLACE,)),
        Piece("dining_table", "middle", front_m=0.6, near=AT_TABLE),
        Piece("bookcase", "corner", (1, 2), front_m=0.5),
        Piece("chest of drawers", "wall", (0, 1), front_m=0.5),
        Piece("filing_cabinet", "corner", (0, 1), front_m=0.4),
        Piece("armchair", "corner", (0, 1), front_m=0.4),
        Piece("floor_lamp", "corner", (0, 1), front_m=0.0),
        Piece("plant", "corner", (2, 3), front_m=0.0),
    ),
    small=(
        *MEDIA,
        *DESKTOP,
        Small(("stove",), ("cooking pot",), (1, 1)),
        Small(("kitchen_cabinet",), ON_WORKTOPS, (1, 3)),
        Small(("dining_table",), ("bowl of fruit", "vase of flowers"), (1, 1), "centre"),
        Small(("dining_table",), ON_DINING_TABLE, (3, 5), "seats"),
        Small(("coffee_table",), ON_COFFEE_TABLE, (2, 4)),
        Small(("bookcase", "chest of drawers"), ON_SHELVES, (3, 5)),
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
        "basketball", "soccer ball", "backpack", "briefcase", "bean bag", "recycling bin",
    ),
    floor_count=(3, 5),
    things=(62, 78),
    hung=("utensil rack", "wall clock", "cuckoo clock", "dartboard", "mirror"),
)  # fmt: skip
