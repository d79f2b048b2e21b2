"""What is built in place rather than taken from a library: its categories."""

from sceneq_tools.room.category import Category

BUILT = ("built in place",)
"""Stands for the models of a category that is made on the spot."""


def _built(
    label: str, role: str, material: str, good_for: tuple[str, ...], also: tuple[str, ...] = ()
) -> Category:
    return Category(label, role, material, good_for, also, BUILT)


FLOOR = _built("floor", "structure", "", ("walk on",))
CEILING = _built("ceiling", "structure", "", ())
WALL = _built("wall", "structure", "", ())
WINDOW = _built("window", "opening", "glass", ("look outside", "let in light", "let in fresh air"))
DOOR = _built("door", "opening", "wood", ("leave the room",))
CURTAIN = _built("curtain", "opening", "fabric", ("keep out the light",), ("curtains", "drapes"))
CEILING_LAMP = _built(
    "ceiling lamp", "ceiling_lamp", "glass", ("light the room",), ("ceiling light",)
)
PAINTING = _built("painting", "wall", "canvas", ("decorate the wall",), ("picture", "wall picture"))
RUG = _built("rug", "rug", "fabric", ("cover the floor",), ("carpet",))
