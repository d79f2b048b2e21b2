"""A room while it is being furnished or changed."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_tools.room.layout.fittings import DOOR
from sceneq_tools.room.layout.footprint import Footprint
from sceneq_tools.room.layout.lights import lights_of
from sceneq_tools.room.layout.placement import collide, footprint, front_area, heights
from sceneq_tools.room.layout.stock import Item
from sceneq_tools.room.layout.wall import Wall, walls_of
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.room import FLOOR_ID, Room, Thing

RUG_M = 0.0015
"""Thickness of rugs: what stands half on one still stands level."""

DOORWAY_M = 0.95
"""Free floor in front of a door."""


@dataclass(frozen=True, slots=True)
class Zone:
    """Floor that has to stay free.

    Attributes:
        area: where; ``above_m``: only what is higher is in its way.
        owner: id of the thing whose companions may stand there, 0 for nobody.
    """

    area: Footprint
    above_m: float = 0.0
    owner: int = 0


class Draft:
    """Things with their places, walls, and floor that has to stay free.

    Attributes:
        size_m: (width, depth, height).
        walls: south, east, north, west.
        things: so far, in the order of their ids; ``zones`` of floor that have to stay free.
        next_id: of the next thing.
        wall_of: the wall that a thing stands at or hangs on, by id.
    """

    def __init__(self, size_m: tuple[float, float, float], rng: np.random.Generator) -> None:
        self.size_m = size_m
        self.rng = rng
        self.walls = walls_of(size_m[0], size_m[1])
        self.things: list[Thing] = []
        self.zones: list[Zone] = []
        self.wall_of: dict[int, Wall] = {}
        self.next_id = FLOOR_ID

    def add(
        self,
        item: Item,
        T_world_thing: Float64,
        support: int | None,
        relation: str = "on",
        is_stuff: bool = False,
    ) -> Thing:
        """Put a thing where it is said to be, and give it the next id."""
        thing = Thing(
            id=self.next_id,
            category=item.category,
            model_id=item.model_id,
            mesh=item.mesh,
            T_world_thing=T_world_thing,
            support=support,
            relation=relation,
            tint=item.tint,
            is_stuff=is_stuff,
        )
        self.next_id += 1
        self.things.append(thing)
        return thing

    def furniture(self) -> list[Thing]:
        """Return what can be in the way: everything but walls, floor, ceiling and rugs."""
        return [thing for thing in self.things if not (thing.is_stuff or is_rug(thing))]

    def named(self, name: str) -> list[Thing]:
        """Return the things of a label or role."""
        return [thing for thing in self.things if name in (thing.label, thing.category.role)]

    def fits(
        self,
        mesh: Mesh,
        T_world: Float64,
        margin_m: float = 0.02,
        company: Collection[int] = (),
        headroom_m: float = 0.0,
    ) -> bool:
        """Tell whether a mesh may stand in a pose.

        Args:
            mesh: what is to be placed.
            T_world: (4, 4) pose in the world.
            margin_m: free distance to everything that is not company.
            company: ids of things it may be close to, and whose zones it may use.
            headroom_m: height of what will stand on it, which must not be before a window.
        """
        area = footprint(mesh, T_world)
        top = heights(mesh, T_world)[1] + headroom_m
        if not area.within(self.size_m[0], self.size_m[1]):
            return False
        if any(self._crosses(zone, area, top, company) for zone in self.zones):
            return False
        return not any(
            self._hinders(mesh, T_world, area.grown(margin_m), thing, company)
            for thing in self.furniture()
        )

    def is_clear(self, area: Footprint, company: Collection[int] = ()) -> bool:
        """Tell whether no furniture stands on a piece of floor and it lies in the room."""
        return area.within(self.size_m[0], self.size_m[1]) and not any(
            thing.id not in company
            and heights(thing.mesh, thing.T_world_thing)[0] < 0.5
            and area.overlaps(footprint(thing.mesh, thing.T_world_thing))
            for thing in self.furniture()
        )

    def resting_height(self, mesh: Mesh, T_world: Float64) -> tuple[float, int]:
        """Return the height of the floor or rug under a mesh, and the id of what carries it."""
        area = footprint(mesh, T_world)
        centre = Footprint(area.x, area.y, 0.01, 0.01)
        for rug in filter(is_rug, self.things):
            spread = footprint(rug.mesh, rug.T_world_thing)
            if spread.overlaps(centre):
                return RUG_M, rug.id
            if spread.overlaps(area):
                return RUG_M, FLOOR_ID
        return 0.0, FLOOR_ID

    def stand(self, item: Item, T_world: Float64) -> Thing:
        """Put a thing on the floor, or on the rug that lies there."""
        height, support = self.resting_height(item.mesh, T_world)
        settled = T_world.copy()
        settled[2, 3] = height
        return self.add(item, settled, support)

    def _crosses(self, zone: Zone, area: Footprint, top: float, company: Collection[int]) -> bool:
        return zone.owner not in company and top > zone.above_m and zone.area.overlaps(area)

    def _hinders(
        self, mesh: Mesh, T_world: Float64, area: Footprint, thing: Thing, company: Collection[int]
    ) -> bool:
        if thing.id in company:
            return collide(mesh, T_world, thing.mesh, thing.T_world_thing)
        low, high = heights(mesh, T_world)
        its_low, its_high = heights(thing.mesh, thing.T_world_thing)
        meets = its_low < high and low < its_high
        return meets and area.overlaps(footprint(thing.mesh, thing.T_world_thing))


def is_rug(thing: Thing) -> bool:
    """Tell whether a thing lies flat on the floor and carries others."""
    return thing.category.role == "rug"


def carried_by(things: Collection[Thing], thing_id: int) -> Iterator[Thing]:
    """Return what stands on or in a thing, and on that, and so on."""
    for thing in things:
        if thing.support == thing_id and thing.relation in ("on", "in"):
            yield thing
            yield from carried_by(things, thing.id)


def drafted(room: Room, rng: np.random.Generator) -> Draft:
    """Return a room opened again for changes."""
    draft = Draft(room.size_m, rng)
    draft.things = list(room.things)
    draft.next_id = max(room.next_id, *(thing.id + 1 for thing in room.things))
    draft.zones = [
        Zone(front_area(thing.mesh, thing.T_world_thing, DOORWAY_M))
        for thing in room.things
        if thing.label == DOOR.label
    ]
    return draft


def finished(draft: Draft, kind: str, seed: int) -> Room:
    """Return what was drafted as a room."""
    things = tuple(draft.things)
    return Room(kind, seed, draft.size_m, things, lights_of(things), draft.next_id)
