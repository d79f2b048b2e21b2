"""Hanging pictures and other things on walls."""

from sceneq_core.arrays import Float64
from sceneq_tools.room.layout.draft import Draft
from sceneq_tools.room.layout.fittings import PAINTING
from sceneq_tools.room.layout.footprint import Footprint
from sceneq_tools.room.layout.framed_painting import framed_painting
from sceneq_tools.room.layout.placement import footprint, heights
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.layout.stock import Item, Stock
from sceneq_tools.room.layout.wall import Wall
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.room import FLOOR_ID, Thing

EYE_M = 1.6
"""The middle of a picture hangs at eye level."""

ABOVE_M = 0.2
"""But its lower edge keeps so far above the furniture."""

AT_WALL_M = 0.3
"""What stands so close to a wall is below the picture."""

BELOW_PAINTINGS = ("sofa", "bed", "desk", "dresser", "armchair", "nightstand", "dining_table")
"""Roles of furniture that pictures are hung above."""

SIZES_M = ((0.35, 0.45), (0.5, 0.4), (0.6, 0.45), (0.7, 0.5), (0.45, 0.6), (0.9, 0.6))


def hang_paintings(draft: Draft, count: int) -> None:
    """Hang paintings: above furniture first, then on free stretches of wall."""
    stretches = [
        (draft.wall_of[thing.id], _middle(draft, thing))
        for thing in draft.furniture()
        if thing.id in draft.wall_of and thing.category.role in BELOW_PAINTINGS
    ]
    stretches = [stretches[i] for i in draft.rng.permutation(len(stretches))]
    for _ in range(20 * count):
        wall = draft.walls[int(draft.rng.integers(4))]
        stretches.append((wall, float(draft.rng.uniform(0.5, wall.length_m - 0.5))))
    item = None
    for wall, along in stretches:
        if count == 0:
            return
        item = item or _new_painting(draft)
        if hang(draft, item, wall, along):
            item, count = None, count - 1


def hang_things(draft: Draft, stock: Stock, names: tuple[str, ...], count: int) -> None:
    """Hang things of a library, such as clocks and mirrors, on free stretches of wall."""
    for name in names[:count]:
        item = stock.draw(name)
        for _ in range(20 if item else 0):
            assert item is not None
            wall = draft.walls[int(draft.rng.integers(4))]
            if hang(draft, item, wall, float(draft.rng.uniform(0.4, wall.length_m - 0.4))):
                break


def hang(draft: Draft, item: Item, wall: Wall, along_m: float) -> bool:
    """Hang something on a wall; tell whether there was place for it."""
    T_world = hanging_place(draft, item.mesh, wall, along_m)
    if T_world is None:
        return False
    thing = draft.add(item, T_world, wall.id, "against")
    draft.wall_of[thing.id] = wall
    return True


def hanging_place(draft: Draft, mesh: Mesh, wall: Wall, along_m: float) -> Float64 | None:
    """Return the pose at eye level, or higher where furniture stands; ``None`` if not free."""
    low, high = bounds(mesh)
    half = float(high[0] - low[0]) / 2
    if not half + 0.05 < along_m < wall.length_m - half - 0.05:
        return None
    bottom = max(
        EYE_M - float(high[2]) / 2, _top_of_furniture(draft, wall, along_m, half) + ABOVE_M
    )
    if bottom + high[2] > draft.size_m[2] - 0.15:
        return None
    T_world = wall.pose(along_m - float(low[0] + high[0]) / 2, float(high[1]) + 0.001, bottom)
    return T_world if draft.fits(mesh, T_world, 0.05) else None


def _new_painting(draft: Draft) -> Item:
    width, height = SIZES_M[int(draft.rng.integers(len(SIZES_M)))]
    return Item(PAINTING, "", framed_painting(draft.rng, width, height), None)


def _middle(draft: Draft, thing: Thing) -> float:
    own = footprint(thing.mesh, thing.T_world_thing)
    return draft.wall_of[thing.id].along(own.x, own.y)


def _top_of_furniture(draft: Draft, wall: Wall, along_m: float, half: float) -> float:
    """Return how high furniture reaches that stands at a stretch of wall, 0 when there is none."""
    x, y = wall.pose(along_m, AT_WALL_M / 2)[:2, 3]
    stretch = Footprint(float(x), float(y), half, AT_WALL_M / 2, wall.yaw)
    tops = [
        heights(thing.mesh, thing.T_world_thing)[1]
        for thing in draft.furniture()
        if thing.support == FLOOR_ID
        and stretch.overlaps(footprint(thing.mesh, thing.T_world_thing))
    ]
    return max(tops, default=0.0)
