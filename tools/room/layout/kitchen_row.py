"""Kitchen furniture side by side along one wall."""

from sceneq_tools.room.layout.draft import Draft, Zone
from sceneq_tools.room.layout.footprint import Footprint
from sceneq_tools.room.layout.plan import Above, Row
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.layout.standing import backed
from sceneq_tools.room.layout.stock import Item, Stock
from sceneq_tools.room.layout.structure import tile_splashback
from sceneq_tools.room.layout.wall import Wall

JOINT_M = 0.004
"""Between neighbours."""

OVERHANG_M = 0.04
"""A cupboard or a hood may be so much wider than what it hangs above."""

LEAST_PIECES = 5
"""Up to sink and stove; a wall for fewer is no kitchen wall."""


def stand_row(draft: Draft, stock: Stock, row: Row) -> Wall | None:
    """Stand a row along the wall where most of it fits, and hang what belongs above.

    Returns:
        the wall; ``None`` when no wall is long enough.
    """
    items = _drawn(draft, stock, row)
    best: tuple[int, float, Wall] | None = None
    for wall in draft.walls:
        for start in (0.04, 0.5, 1.0, 1.5):
            count = _fitting(draft, items, wall, start)
            choice = (count, float(draft.rng.uniform(0, 1)), wall)
            if best is None or choice[:2] > best[:2]:
                best, best_start = choice, start
    if best is None or best[0] < min(LEAST_PIECES, len(items)):
        return None
    _stand(draft, stock, row, items[: best[0]], best[2], best_start)
    return best[2]


def _drawn(draft: Draft, stock: Stock, row: Row) -> list[Item]:
    """Choose the models; those of the worktop are all the same."""
    names = list(row.base)
    if row.optional and draft.rng.random() < 0.6:
        place = int(draft.rng.integers(LEAST_PIECES, len(names) + 1))
        names.insert(place, str(draft.rng.choice(row.optional)))
    same = {name: stock.draw(name) for name in row.tops}
    drawn = [same[name] if name in same else stock.draw(name) for name in names]
    return [item for item in drawn if item is not None]


def _width(item: Item) -> float:
    low, high = bounds(item.mesh)
    return float(high[0] - low[0])


def _fitting(draft: Draft, items: list[Item], wall: Wall, start: float) -> int:
    """Return how many of the items fit side by side from ``start`` metres on."""
    end = start
    for count, item in enumerate(items):
        T_world = backed(item.mesh, wall, end + _width(item) / 2)
        end += _width(item) + JOINT_M
        if end > wall.length_m - 0.03 or not draft.fits(item.mesh, T_world, 0.0):
            return count
    return len(items)


def _stand(
    draft: Draft, stock: Stock, row: Row, items: list[Item], wall: Wall, start: float
) -> None:
    left = start
    spans: list[tuple[str, float, float]] = []
    for item in items:
        right = left + _width(item)
        thing = draft.stand(item, backed(item.mesh, wall, (left + right) / 2))
        draft.wall_of[thing.id] = wall
        spans.append((item.category.role, left, right))
        left = right + JOINT_M
    for above in row.above:
        for begin, end in _runs(spans, above.over):
            _hang(draft, stock, above, wall, begin, end)
    x, y = wall.pose((start + left) / 2, 0.35 + row.front_m / 2)[:2, 3]
    area = Footprint(float(x), float(y), (left - start) / 2, row.front_m / 2 + 0.3, wall.yaw)
    draft.zones.append(Zone(area))
    tile_splashback(draft, wall, start, left)


def _runs(
    spans: list[tuple[str, float, float]], over: tuple[str, ...]
) -> list[tuple[float, float]]:
    """Return the unbroken stretches of a row that consist of some roles only."""
    runs: list[tuple[float, float]] = []
    for role, left, right in spans:
        if role not in over:
            continue
        if runs and left - runs[-1][1] < 2 * JOINT_M:
            runs[-1] = (runs[-1][0], right)
        else:
            runs.append((left, right))
    return runs


def _hang(draft: Draft, stock: Stock, above: Above, wall: Wall, left: float, right: float) -> None:
    """Hang the same cupboard side by side over a stretch, but not before a window."""
    item = stock.narrow(above.what, right - left + OVERHANG_M)
    if item is None:
        return
    count = int((right - left + OVERHANG_M) / _width(item))
    begin = (left + right - count * _width(item)) / 2
    for i in range(count):
        T_world = backed(item.mesh, wall, begin + (i + 0.5) * _width(item), 0.001)
        T_world[2, 3] = above.bottom_m
        if draft.fits(item.mesh, T_world, -JOINT_M):
            thing = draft.add(item, T_world, wall.id, "against")
            draft.wall_of[thing.id] = wall
