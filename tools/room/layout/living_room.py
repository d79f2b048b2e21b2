"""Living rooms: a sofa that faces a television, shelves, plants, toys."""

from sceneq_tools.room.layout.plan import Near, Piece, Plan, Small

LOUNGE = Piece(
    "sofa",
    "centre",
    front_m=1.3,
    near=(
        Near("rug", "beneath"),
        Near("tv_stand", "across", needed=True),
        Near("coffee_table", "ahead", gap_m=0.35),
        Near("armchair", "aside", (1, 2)),
        Near("floor_lamp", "beside", gap_m=0.1),
        Near("nightstand", "beside", (0, 1), gap_m=0.06),
    ),
    needed=True,
)

ON_SHELVES = (
    "vase", "picture frame", "teddy bear", "toy car", "Rubik's cube", "camera", "alarm clock",
    "toy train", "gift box", "gift box", "cactus", "folded clothes", "book", "book", "book", "vase",
    "hat", "radio", "candle", "succulent", "helmet", "bonsai tree", "speaker", "chessboard",
    "deer figurine", "toy airplane", "xylophone", "doll",
)  # fmt: skip

ON_COFFEE_TABLE = (
    "remote control", "book", "coffee mug", "coffee mug", "candle", "newspaper", "game controller",
    "chessboard", "bowl", "paper cup", "tablet", "bowl of fruit", "wine bottle", "coffee cup",
    "wine glass", "glasses", "playing cards", "keys", "tea cup",
)  # fmt: skip

MEDIA = (
    Small(("tv_stand",), ("television",), (1, 1), "back", straight=True),
    Small(
        ("tv_stand",),
        (
            "game console", "speaker", "speaker", "game controller", "remote control", "vase",
            "picture frame", "DVD player",
        ),
        (2, 4),
    ),
)  # fmt: skip

LIVING_ROOM = Plan(
    kind="living_room",
    width_m=(4.4, 6.0),
    depth_m=(3.9, 5.0),
    windows=(1, 2),
    pictures=(3, 6),
    row=None,
    pieces=(
        LOUNGE,
        Piece("bookcase", "corner", (1, 2), front_m=0.5),
        Piece("chest of drawers", "wall", (1, 1), front_m=0.5),
        Piece("desk", "wall", (0, 1), near=(Near("chair", "tucked"),)),
        Piece("upright piano", "wall", (0, 1), front_m=0.6),
        Piece("plant", "corner", (2, 4), front_m=0.0),
    ),
    small=(
        *MEDIA,
        Small(("chest of drawers",), ("table lamp",), (1, 1)),
        Small(("coffee_table",), ON_COFFEE_TABLE, (4, 6)),
        Small(("bookcase",), ON_SHELVES, (5, 8)),
        Small(
            ("chest of drawers", "desk"),
            (
                "radio", "vase", "picture frame", "gift box", "handbag", "fan", "orchid",
                "bonsai tree", "vase of flowers", "laptop", "book", "book", "coffee mug",
                "telephone", "stereo",
            ),
            (3, 5),
        ),
        Small(
            ("nightstand",),
            ("table lamp", "alarm clock", "cordless phone", "book", "candle"),
            (2, 3),
        ),
        Small(
            ("sofa",),
            (
                "backpack", "handbag", "teddy bear", "book", "folded clothes", "hat", "headphones",
                "game controller",
            ),
            (1, 3),
        ),
        Small(("armchair",), ("teddy bear", "book", "newspaper", "hat", "cap", "tablet"), (0, 1)),
        Small(
            ("coffee_table", "desk"),
            ("slippers", "basketball", "cardboard box", "toy car", "soccer ball", "gift box"),
            (0, 1), relation="under",
        ),
    ),
    floor=(
        "guitar", "basketball", "soccer ball", "slippers", "sneakers", "suitcase", "backpack",
        "fan", "gift box", "shopping basket", "cardboard box", "bean bag", "doll house", "tricycle",
        "rocking horse",
    ),
    floor_count=(2, 4),
    things=(55, 75),
)  # fmt: skip
