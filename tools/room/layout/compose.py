"""Rooms of five kinds, decided by a seed."""

import zlib

import numpy as np

from sceneq_tools.room.layout.bedroom import BEDROOM
from sceneq_tools.room.layout.draft import Draft, finished
from sceneq_tools.room.layout.furnishing import Furnishing
from sceneq_tools.room.layout.hanging import hang_paintings, hang_things
from sceneq_tools.room.layout.kitchen import KITCHEN
from sceneq_tools.room.layout.living_room import LIVING_ROOM
from sceneq_tools.room.layout.mixed import MIXED
from sceneq_tools.room.layout.office import OFFICE
from sceneq_tools.room.layout.openings import build_openings, choose_openings
from sceneq_tools.room.layout.plan import Plan
from sceneq_tools.room.layout.stock import Stock
from sceneq_tools.room.layout.structure import build_structure
from sceneq_tools.room.layout.ways import is_walkable
from sceneq_tools.room.library import Library
from sceneq_tools.room.room import KINDS, Room

PLANS = {plan.kind: plan for plan in (KITCHEN, LIVING_ROOM, OFFICE, BEDROOM, MIXED)}

ATTEMPTS = 8
"""So often a room is drawn again when a piece it needs finds no place."""


def compose(kind: str, seed: int, library: Library) -> Room:
    """Furnish a room; the same arguments always give the same room.

    Args:
        kind: one of ``KINDS``.
        seed: decides size, openings, finishes, furniture and things.
        library: where the models come from; what it does not have is left out.

    Raises:
        ValueError: unknown kind.
    """
    if kind not in PLANS:
        raise ValueError(f"kind: expected one of {', '.join(KINDS)}, got {kind!r}")
    plan = PLANS[kind]
    best: tuple[int, Draft, Stock] | None = None
    for attempt in range(ATTEMPTS):
        rng = np.random.default_rng([zlib.crc32(kind.encode()), seed, attempt])
        draft, stock, missing = _furnished(plan, library, rng)
        if best is None or len(missing) < best[0]:
            best = (len(missing), draft, stock)
        if not missing:
            break
    assert best is not None
    draft, stock = best[1:]
    _decorate(plan, draft, stock)
    return finished(draft, kind, seed)


def _furnished(
    plan: Plan, library: Library, rng: np.random.Generator
) -> tuple[Draft, Stock, list[str]]:
    """Build the walls and place the furniture; also return what found no place."""
    size = (_metres(rng, plan.width_m), _metres(rng, plan.depth_m), _metres(rng, (2.55, 2.85)))
    draft = Draft(size, rng)
    stock = Stock(library, rng)
    windows = int(rng.integers(plan.windows[0], plan.windows[1] + 1))
    openings = choose_openings(draft, windows)
    build_structure(draft, plan.floors, openings.holes())
    build_openings(draft, openings)
    missing = Furnishing(draft, stock).furnish(plan)
    if not is_walkable(draft):
        missing.append("a way through the room")
    return draft, stock, missing


def _decorate(plan: Plan, draft: Draft, stock: Stock) -> None:
    """Hang pictures and put small things on the furniture."""
    rng = draft.rng
    hung = tuple(rng.permutation([name for name in plan.hung if stock.has(name)]).tolist())
    hang_things(draft, stock, hung, int(rng.integers(0, 3)))
    hang_paintings(draft, int(rng.integers(plan.pictures[0], plan.pictures[1] + 1)))
    Furnishing(draft, stock).fill(plan)


def _metres(rng: np.random.Generator, between: tuple[float, float]) -> float:
    return round(float(rng.uniform(*between)), 2)
