"""Where in a room a person can stand and how they walk from one place to another."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_tools.room.camera.glance import corners_world
from sceneq_tools.room.room import Room, Thing

CELL_M = 0.05
BODY_M = (0.10, 1.90)
"""What lies between these heights is in a walker's way: not the rug, not the ceiling lamp."""
ROOM_TO_SPARE = 0.12
"""How much longer a path seems per metre that is only a metre from the next obstacle."""

SQUEEZED_M = 0.25
REACHED = 0.9
"""Of the floor where somebody fits at all this part must be reached, through narrower gaps."""
CUT = 0.6
"""In a bend this part of the distance that is kept otherwise."""


@dataclass(frozen=True, slots=True)
class PlanParams:
    """``body_m``: how far the walker's axis keeps from everything; ``least_m``: in a full room."""

    body_m: float = 0.30
    least_m: float = 0.12

    def __post_init__(self) -> None:
        if not 0 < self.least_m <= self.body_m:
            raise ValueError(f"least_m: expected between 0 and body_m, got {self.least_m}")


class FloorPlan:
    """A grid over the floor of a room, ``CELL_M`` wide, indexed [x, y].

    Attributes:
        obstacle_m: float64 (X, Y) metres from the cell to the next thing or wall, 0 inside one.
        body_m: what a walker keeps clear here.
        free: bool (X, Y), one connected region that keeps ``body_m`` clear.
    """

    def __init__(self, room: Room, params: PlanParams | None = None) -> None:
        """Draw the plan; raise ``ValueError`` when nobody fits between the furniture."""
        params = params or PlanParams()
        self.obstacle_m = _distance_m(_occupied(room))
        self.body_m = params.body_m
        self.free = _largest(self.obstacle_m > self.body_m)
        while self.free.sum() < self._wanted() and self.body_m > params.least_m:
            self.body_m = max(self.body_m - CELL_M, params.least_m)
            self.free = _largest(self.obstacle_m > self.body_m)
        if not self.free.any():
            raise ValueError(f"{room.kind} {room.seed}: the floor is full, nobody can walk there")

    def _wanted(self) -> float:
        """Return how many cells to reach before squeezing through gaps is not worth it."""
        return REACHED * float((self.obstacle_m > SQUEEZED_M).sum())

    @cached_property
    def cells(self) -> Int64:
        """Return the free cells, int64 (N, 2)."""
        return np.argwhere(self.free)

    @cached_property
    def places(self) -> Float64:
        """Return the middles of the free cells, float64 (N, 2) metres."""
        return np.asarray((self.cells + 0.5) * CELL_M, dtype=np.float64)

    def nearest(self, xy: Float64) -> int:
        """Return the index of the free cell nearest to a point on the floor."""
        return int(((self.places - xy) ** 2).sum(axis=1).argmin())

    def clear_m(self, points_xy: Float64) -> Float64:
        """Return how far points (N, 2) of the floor are from the next obstacle, to a cell."""
        cell = np.clip(np.floor(points_xy / CELL_M).astype(int), 0, np.array(self.free.shape) - 1)
        return np.asarray(self.obstacle_m[cell[:, 0], cell[:, 1]])

    def ways_from(self, place: int) -> "Ways":
        """Return the shortest ways from a free cell to all others."""
        from scipy.sparse.csgraph import dijkstra

        length_m, before = dijkstra(
            self._steps, directed=False, indices=place, return_predecessors=True
        )
        return Ways(self, place, length_m, before)

    @cached_property
    def _steps(self) -> "object":
        """Return the graph of steps between neighbouring free cells."""
        from scipy.sparse import csr_matrix

        index = np.full(self.free.shape, -1)
        index[self.free] = np.arange(len(self.cells))
        rows, columns, costs = [], [], []
        for dx, dy in ((1, 0), (0, 1), (1, 1), (1, -1)):
            a, b = _neighbours(index, dx, dy)
            linked = (a >= 0) & (b >= 0)
            spare_m = self.obstacle_m[self.free][a[linked]]
            rows.append(a[linked])
            columns.append(b[linked])
            costs.append(np.hypot(dx, dy) * CELL_M * (1 + ROOM_TO_SPARE / spare_m))
        shape = (len(self.cells),) * 2
        entries = (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns)))
        return csr_matrix(entries, shape=shape)


@dataclass(frozen=True, slots=True, eq=False)
class Ways:
    """The shortest ways from ``start``; ``cost_m`` (N,) their lengths, a little more when tight."""

    plan: FloorPlan
    start: int
    cost_m: Float64
    before: Int64

    def to(self, place: int) -> Float64:
        """Return the way to a free cell as points (M, 2), M >= 1, rounded where there is room."""
        cells = [place]
        while cells[-1] != self.start:
            cells.append(int(self.before[cells[-1]]))
        return _rounded(self.plan.places[cells[::-1]], self.plan)


def _rounded(way: Float64, plan: FloorPlan) -> Float64:
    """Round the corners of a way, and cut them a little, for nobody turns on the spot."""
    from scipy.ndimage import gaussian_filter1d

    for sigma in (12, 8, 5, 3, 2, 1):
        padded = np.concatenate([[way[0]] * 3 * sigma, way, [way[-1]] * 3 * sigma])
        smooth: Float64 = gaussian_filter1d(padded, sigma, axis=0, mode="nearest")
        smooth[0], smooth[-1] = way[0], way[-1]
        if plan.clear_m(smooth).min() >= CUT * plan.body_m:
            return smooth
    return way


def outline(thing: Thing) -> Float64:
    """Return the convex outline (N, 2) of what of a thing is in a walker's way; N may be 0."""
    corners = corners_world(thing)
    in_the_way = (corners[..., 2].max(axis=1) > BODY_M[0]) & (
        corners[..., 2].min(axis=1) < BODY_M[1]
    )
    points = corners[in_the_way][..., :2].reshape(-1, 2)
    if len(points) == 0:
        return np.empty((0, 2))
    return np.asarray(cv2.convexHull(points.astype(np.float32))[:, 0], dtype=np.float64)


def _occupied(room: Room) -> Bool:
    shape = (int(np.ceil(room.size_m[0] / CELL_M)), int(np.ceil(room.size_m[1] / CELL_M)))
    occupied = np.zeros(shape, np.uint8)
    for thing in room.things:
        corners = np.empty((0, 2)) if thing.is_stuff else outline(thing)
        if len(corners):
            # cv2 counts columns first, from the middle of a cell, here in 1/16 of one.
            pixels = np.round((corners[:, ::-1] / CELL_M - 0.5) * 16).astype(np.int32)
            cv2.fillConvexPoly(occupied, pixels, 1, shift=4)
    return occupied > 0


def _distance_m(occupied: Bool) -> Float64:
    from scipy.ndimage import distance_transform_edt

    walled = np.pad(occupied, 1, constant_values=True)
    return np.asarray(distance_transform_edt(~walled)[1:-1, 1:-1] * CELL_M)


def _largest(free: Bool) -> Bool:
    from scipy.ndimage import label

    regions, count = label(free)
    if count == 0:
        return free
    return np.asarray(regions == 1 + np.bincount(regions.ravel())[1:].argmax())


def _neighbours(index: Int64, dx: int, dy: int) -> tuple[Int64, Int64]:
    """Return the flat indices of every cell and of the one (dx, dy) further."""
    a = index[: len(index) - dx, max(0, -dy) : index.shape[1] - max(0, dy)]
    b = index[dx:, max(0, dy) : index.shape[1] - max(0, -dy)]
    return a.ravel(), b.ravel()
