"""A room: walls, furniture, things on things, and lights. Immutable; edits make a new one."""

from dataclasses import dataclass

from sceneq_core.arrays import Float64
from sceneq_tools.room.category import Category
from sceneq_tools.room.mesh import Colour, Mesh

KINDS = ("kitchen", "living_room", "office", "bedroom", "mixed")
FLOOR_ID = 1


@dataclass(frozen=True, slots=True, eq=False)
class Thing:
    """One object in its place.

    Attributes:
        id: instance id, 1 to 65535, unique in the room over all its periods; never used twice.
        category: what it is.
        model_id: of the library, ``""`` for what is built in place (walls, pictures, rugs).
        mesh: in its own frame.
        T_world_thing: (4, 4) rigid, metres; rotated about z only, except what hangs or leans.
        support: id of what carries it (the floor, a table, a wall).
        relation: how it is there: ``on``, ``in``, ``under`` or ``against`` (hung on a wall).
        tint: name of its paint, ``None`` as the model is.
        is_stuff: floor, wall or ceiling, which nobody asks for.
    """

    id: int
    category: Category
    model_id: str
    mesh: Mesh
    T_world_thing: Float64
    support: int | None = None
    relation: str = "on"
    tint: str | None = None
    is_stuff: bool = False

    @property
    def label(self) -> str:
        """What it is called."""
        return self.category.label


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """A one-sided rectangle that shines: ``corner + a * edge_u + b * edge_v``, a, b in 0..1.

    It shines towards ``cross(edge_u, edge_v)``. ``radiance`` is linear RGB.
    """

    corner: Float64
    edge_u: Float64
    edge_v: Float64
    radiance: Colour


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """Everything that is rendered; ``size_m`` is (width, depth, height).

    ``next_id`` goes to the next new thing: ids of removed things are not given out again.
    """

    kind: str
    seed: int
    size_m: tuple[float, float, float]
    things: tuple[Thing, ...]
    lights: tuple[Light, ...]
    next_id: int = 0

    def thing(self, thing_id: int) -> Thing:
        """Return the thing with this id; raise ``KeyError`` when there is none."""
        for thing in self.things:
            if thing.id == thing_id:
                return thing
        raise KeyError(thing_id)
