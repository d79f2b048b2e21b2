"""Cutting windows and a door into the walls."""

from dataclasses import dataclass

from sceneq_tools.room.layout.door import DOOR_M, door_mesh
from sceneq_tools.room.layout.draft import DOORWAY_M, Draft, Zone
from sceneq_tools.room.layout.fittings import CEILING_LAMP, CURTAIN, DOOR, WINDOW
from sceneq_tools.room.layout.footprint import Footprint
from sceneq_tools.room.layout.lamp import LAMP_DROP_M, ceiling_lamp_mesh
from sceneq_tools.room.layout.placement import front_area, pose
from sceneq_tools.room.layout.stock import Item
from sceneq_tools.room.layout.structure import Hole
from sceneq_tools.room.layout.wall import Wall
from sceneq_tools.room.layout.window import curtain_cloth, curtain_mesh, window_mesh
from sceneq_tools.room.mesh import Material

LIGHT_WAY_M = 0.55
"""Nothing higher than the sill stands so close to a window."""

CEILING_ID = 2


@dataclass(frozen=True, slots=True)
class Openings:
    """Where the door and the windows will be."""

    door_wall: Wall
    door_left: float
    windows: tuple[tuple[Wall, Hole], ...]

    def holes(self) -> dict[int, list[Hole]]:
        """Return what is cut out of the walls, by side; a closed door needs no hole."""
        cut: dict[int, list[Hole]] = {}
        for wall, hole in self.windows:
            cut.setdefault(wall.side, []).append(hole)
        return cut


def choose_openings(draft: Draft, windows: int) -> Openings:
    """Choose a wall and a place for the door, and other walls for the windows."""
    rng = draft.rng
    sides = [int(side) for side in rng.permutation(4)]
    door_wall = draft.walls[sides[0]]
    free = door_wall.length_m - DOOR_M[0]
    door_left = float(rng.choice([0.12, free - 0.12]))
    return Openings(
        door_wall,
        door_left,
        tuple(
            (draft.walls[side], _window_hole(draft, draft.walls[side]))
            for side in sides[1 : 1 + windows]
        ),
    )


def build_openings(draft: Draft, openings: Openings) -> None:
    """Add the door, the windows with their curtains, and the ceiling lamp."""
    rng = draft.rng
    wall = openings.door_wall
    door = Item(DOOR, "", door_mesh(rng), None)
    T_world_door = wall.pose(openings.door_left)
    draft.add(door, T_world_door, wall.id, "against")
    draft.zones.append(Zone(front_area(door.mesh, T_world_door, DOORWAY_M)))
    cloth = curtain_cloth(rng)
    for wall, hole in openings.windows:
        _build_window(draft, wall, hole, cloth)
    lamp = Item(CEILING_LAMP, "", ceiling_lamp_mesh(rng), None)
    width, depth, height = draft.size_m
    draft.add(lamp, pose(width / 2, depth / 2, height - LAMP_DROP_M), CEILING_ID, "against")


def _build_window(draft: Draft, wall: Wall, hole: Hole, cloth: Material) -> None:
    rng = draft.rng
    width, height = hole.right - hole.left, hole.top - hole.bottom
    window = Item(WINDOW, "", window_mesh(rng, width, height), None)
    draft.add(window, wall.pose(hole.left, 0.0, hole.bottom), wall.id, "against")
    low = hole.bottom
    if rng.random() < 0.6:
        rod = width + 0.5
        mesh = curtain_mesh(rng, cloth, rod, height + 0.2)
        T_world = wall.pose((hole.left + hole.right) / 2, 0.06, hole.bottom - 0.08)
        draft.add(Item(CURTAIN, "", mesh, None), T_world, wall.id, "against")
        low -= 0.1
    draft.zones.append(Zone(_before(wall, hole.left, hole.right, LIGHT_WAY_M), above_m=low))


def _window_hole(draft: Draft, wall: Wall) -> Hole:
    width = float(draft.rng.uniform(1.0, min(2.0, wall.length_m - 1.6)))
    spare = (wall.length_m - width) / 2
    left = spare + float(draft.rng.uniform(-1, 1)) * max(spare - 0.6, 0.0)
    bottom = float(draft.rng.uniform(0.92, 1.0))
    return Hole(left, left + width, bottom, float(draft.rng.uniform(2.1, 2.25)))


def _before(wall: Wall, left: float, right: float, deep: float) -> Footprint:
    x, y = wall.pose((left + right) / 2, deep / 2)[:2, 3]
    return Footprint(float(x), float(y), (right - left) / 2, deep / 2, wall.yaw)
