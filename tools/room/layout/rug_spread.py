"""Rugs: woven to measure and spread on the floor."""

from dataclasses import replace

import numpy as np

from sceneq_tools.room.layout.draft import RUG_M, Draft, is_rug
from sceneq_tools.room.layout.fittings import RUG
from sceneq_tools.room.layout.footprint import Footprint
from sceneq_tools.room.layout.placement import footprint, pose
from sceneq_tools.room.layout.sheets import sheet
from sceneq_tools.room.layout.stock import Item, Stock
from sceneq_tools.room.mesh import Material, Mesh
from sceneq_tools.room.models.solids import assembled
from sceneq_tools.room.room import FLOOR_ID, Thing
from sceneq_tools.room.textures import textures

SIZES_M = ((1.4, 0.9), (1.7, 1.2), (2.0, 1.4), (2.4, 1.7))
"""Rugs are sold in few sizes."""


def rug_mesh(rng: np.random.Generator, width_m: float, depth_m: float) -> Mesh:
    """Weave a rug: a sheet, so thin that what stands half on it still stands level."""
    pixels = 576 / width_m
    pattern = textures.rug(rng, height_px=int(depth_m * pixels), width_px=576)
    pile = Material((1, 1, 1), pattern)
    top = sheet(pile, (-width_m / 2, -depth_m / 2, RUG_M), (width_m, 0, 0), (0, depth_m, 0))
    shown = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float64)
    return assembled([replace(top, uv=shown)])


def spread_rug(draft: Draft, stock: Stock, host: Thing) -> Thing | None:
    """Spread a rug in front of a piece of furniture, or below it when it stands free."""
    own = footprint(host.mesh, host.T_world_thing)
    width, depth = SIZES_M[int(draft.rng.integers(len(SIZES_M)))]
    wall = draft.wall_of.get(host.id)
    reach = 0.0 if wall is None else own.half_depth + depth / 2 - 0.25
    x, y = own.at(float(draft.rng.normal(0, 0.05)), -reach)
    T_world = pose(x, y, 0.0, own.yaw)
    area = Footprint(x, y, width / 2, depth / 2, own.yaw)
    inside = area.within(draft.size_m[0], draft.size_m[1])
    taken = any(
        area.overlaps(footprint(r.mesh, r.T_world_thing)) for r in filter(is_rug, draft.things)
    )
    if not inside or taken:
        return None
    return draft.add(Item(RUG, "", rug_mesh(draft.rng, width, depth), None), T_world, FLOOR_ID)
