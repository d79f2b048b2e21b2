"""Rooms of boxes put down by chance: enough for every kind of question."""

import numpy as np

from sceneq_tools.room.category import Category
from sceneq_tools.room.mesh import Colour
from sceneq_tools.room.room import FLOOR_ID, Room, Thing

from support.boxed_room import box, placed

PAINTS: dict[str, Colour] = {
    "red": (0.76, 0.1, 0.09),
    "blue": (0.13, 0.3, 0.68),
    "yellow": (0.95, 0.8, 0.16),
    "white": (0.92, 0.92, 0.9),
}
SMALL = (
    Category("coffee mug", "top", "ceramic", ("drink from",), ("mug",), ("box",), tuple(PAINTS)),
    Category("plastic cup", "top", "plastic", ("drink from",), (), ("box",), tuple(PAINTS)),
    Category("book", "top", "paper", ("read",), (), ("box",)),
    Category("gift box", "top", "paper", (), ("present",), ("box",), tuple(PAINTS)),
    Category("basket", "floor", "wicker", ("carry things",), (), ("box",)),
)
LARGE = (
    (Category("dining table", "dining_table", "wood", ("eat at",), ("table",), ("box",)), 0.74),
    (Category("desk", "desk", "wood", ("work at",), (), ("box",)), 0.72),
    (Category("sofa", "sofa", "fabric", ("sit", "lie down"), ("couch",), ("box",)), 0.5),
)
FLOOR = Category("floor", "", "wood", (), (), ("",))


def random_room(seed: int, small: int = 12) -> Room:
    """Tables in a row, with small things on them, under them and beside them."""
    rng = np.random.default_rng(seed)
    floor = _thing(FLOOR_ID, FLOOR, (8.0, 6.0, 0.1), (4.0, 3.0, -0.1), None, is_stuff=True)
    things = [floor]
    for k, (category, height) in enumerate(LARGE):
        size = (float(rng.uniform(1.0, 1.6)), float(rng.uniform(0.6, 0.9)), height)
        things.append(_thing(2 + k, category, size, (1.3 + 2.6 * k, 3.0, 0.0), FLOOR_ID))
    for k in range(small):
        things.append(_small(10 + k, things[1 : 1 + len(LARGE)], rng))
    return Room("office", seed, (8.0, 6.0, 2.6), tuple(things), ())


def _small(thing_id: int, large: list[Thing], rng: np.random.Generator) -> Thing:
    category = SMALL[int(rng.integers(len(SMALL)))]
    tint = str(rng.choice(list(PAINTS))) if category.tints else None
    size = tuple(float(x) for x in rng.uniform(0.06, 0.35, 3))
    below = large[int(rng.integers(len(large)))]
    x, y = below.T_world_thing[:2, 3] + rng.uniform(-0.25, 0.25, 2)
    if rng.random() < 0.6:
        top = float(below.mesh.vertices[:, 2].max())
        return _thing(thing_id, category, size, (x, y, top), below.id, tint)
    y += float(rng.choice([0.0, -0.8, -1.5, 1.2]))
    return _thing(thing_id, category, size, (x, y, 0.0), FLOOR_ID, tint)


def _thing(
    id: int,
    category: Category,
    size_m: tuple[float, ...],
    at: tuple[float, float, float],
    support: int | None,
    tint: str | None = None,
    is_stuff: bool = False,
) -> Thing:
    colour = PAINTS[tint] if tint else (0.6, 0.6, 0.6)
    mesh = box((size_m[0], size_m[1], size_m[2]), colour)
    return Thing(id, category, "box", mesh, placed(*at), support, "on", tint, is_stuff)
