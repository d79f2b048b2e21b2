"""Kitchens: a row along one wall, a dining table, and what cooks and eaters leave about."""

from sceneq_tools.room.layout.plan import Above, Near, Piece, Plan, Row, Small

ROW = Row(
    base=(
        "refrigerator",
        "kitchen_cabinet",
        "kitchen_sink",
        "kitchen_cabinet",
        "stove",
        "kitchen_cabinet",
        "kitchen_cabinet",
    ),
    optional=("washing_machine",),
    above=(
        Above("range_hood", 1.6, over=("stove",)),
        Above("upper_cabinet", 1.5, over=("kitchen_cabinet", "kitchen_sink", "washing_machine")),
    ),
    tops=("kitchen_cabinet",),
)

ON_WORKTOPS = (
    "microwave", "toaster", "coffee maker", "espresso machine", "kettle", "coffee mug",
    "coffee mug", "coffee mug", "knife block", "cutting board", "wine bottle", "beer bottle",
    "paper towel holder", "bread", "kitchen scale", "blender", "mixer", "bowl", "bowl",
    "milk carton", "plastic cup", "plastic cup", "salt shaker", "bowl of apples", "tray", "teapot",
    "plate", "radio", "French press", "moka pot", "utensil holder", "bread box", "rice cooker",
    "toaster oven", "spice rack", "juicer", "soap dispenser", "oil and vinegar set",
)  # fmt: skip

ON_DINING_TABLE = (
    "coffee cup", "plate", "plate", "plastic cup", "wine bottle", "vase of flowers",
    "bowl of salad", "birthday cake", "newspaper", "teapot", "coffee mug", "candle", "bowl",
    "hamburger", "salt shaker", "coffee cup", "milk carton", "drinking glass", "wine glass",
    "sugar bowl", "milk jug", "cupcake", "roast chicken",
)  # fmt: skip

KITCHEN = Plan(
    kind="kitchen",
    width_m=(4.2, 5.4),
    depth_m=(3.7, 4.6),
    windows=(1, 2),
    pictures=(1, 3),
    row=ROW,
    pieces=(
        Piece(
            "dining_table",
            "middle",
            front_m=0.5,
            near=(Near("chair", "around", (3, 6)),),
            needed=True,
        ),
        Piece("chest of drawers", "corner", (0, 1), front_m=0.4),
        Piece("bookcase", "corner", (0, 1), front_m=0.4),
        Piece("stool", "wall", (0, 2), front_m=0.0),
        Piece("plant", "corner", (1, 2), front_m=0.0),
    ),
    small=(
        Small(("stove",), ("cooking pot",), (1, 1)),
        Small(("dining_table",), ("bowl of fruit", "vase of flowers"), (1, 1), "centre"),
        Small(("kitchen_cabinet",), ON_WORKTOPS, (3, 6)),
        Small(("dining_table",), ON_DINING_TABLE, (5, 8), "seats"),
        Small(("kitchen_sink",), ("plate", "bowl"), (1, 1)),
        Small(("kitchen_sink",), ("coffee mug", "plastic cup"), (0, 1)),
        Small(("washing_machine",), ("folded clothes", "shopping basket"), (0, 1)),
        Small(
            ("chest of drawers", "bookcase"),
            (
                "cactus", "radio", "fan", "vase", "picture frame", "bowl", "book", "succulent",
                "alarm clock",
            ),
            (2, 4),
        ),
        Small(
            ("chair", "stool"),
            ("backpack", "handbag", "hat", "cap", "newspaper", "teddy bear"),
            (0, 1),
        ),
        Small(
            ("dining_table",),
            ("cardboard box", "shopping basket", "slippers", "soccer ball"),
            (0, 1), relation="under",
        ),
    ),
    floor=(
        "trash can", "fire extinguisher", "shopping basket", "cardboard box", "backpack",
        "slippers", "recycling bin",
    ),
    floor_count=(2, 4),
    things=(50, 70),
    hung=("utensil rack", "wall clock", "cuckoo clock"),
    floors=("tiles", "planks"),
)  # fmt: skip
