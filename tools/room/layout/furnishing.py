"""Carrying out the plan of a room."""

from sceneq_tools.room.layout.draft import Draft
from sceneq_tools.room.layout.kitchen_row import stand_row
from sceneq_tools.room.layout.plan import Near, Piece, Plan, Row, Small
from sceneq_tools.room.layout.putting import put
from sceneq_tools.room.layout.rug_spread import spread_rug
from sceneq_tools.room.layout.standing import (
    stand_anywhere,
    stand_at_wall,
    stand_in_middle,
    stand_near,
)
from sceneq_tools.room.layout.stock import Stock
from sceneq_tools.room.room import Thing

MODELS_TRIED = 3
"""When the first model is too large for the room, another one may fit."""


class Furnishing:
    """Puts furniture and things into a draft as a plan says; what does not fit is left out."""

    def __init__(self, draft: Draft, stock: Stock) -> None:
        self._draft = draft
        self._stock = stock
        self._rng = draft.rng
        self._missing: list[str] = []

    def furnish(self, plan: Plan) -> list[str]:
        """Place the furniture; return what is needed but found no place."""
        if plan.row is not None and not self._row(plan.row):
            self._missing.append("kitchen row")
        for piece in plan.pieces:
            placed = [self._piece(piece) for _ in range(self._count(piece.count))]
            if piece.needed and None in placed and self._stock.has(piece.what):
                self._missing.append(piece.what)
        return self._missing

    def fill(self, plan: Plan) -> None:
        """Place the small things, and more of them until the room is full enough."""
        self._floor(plan)
        for small in plan.small:
            for name in small.on:
                for host in self._draft.named(name):
                    left = max(plan.things[1] - len(self._draft.things), 0)
                    self._scatter(small, host, min(self._count(small.count), left))
        target = self._count(plan.things)
        for _ in range(3 * target):
            if len(self._draft.things) >= target:
                return
            small = plan.small[int(self._rng.integers(len(plan.small)))]
            hosts = [h for name in small.on for h in self._draft.named(name)]
            if hosts and small.count[1] > 1:
                self._scatter(small, hosts[int(self._rng.integers(len(hosts)))], 1)

    def _count(self, count: tuple[int, int]) -> int:
        return int(self._rng.integers(count[0], count[1] + 1))

    def _piece(self, piece: Piece) -> Thing | None:
        for _ in range(MODELS_TRIED):
            item = self._stock.draw(piece.what)
            if item is None:
                return None
            if piece.where == "middle":
                thing = stand_in_middle(self._draft, item, piece.front_m)
            else:
                thing = stand_at_wall(self._draft, item, piece.where, piece.front_m)
            if thing is not None:
                for near in piece.near:
                    self._companions(thing, near)
                return thing
        return None

    def _companions(self, host: Thing, near: Near) -> None:
        if near.where == "beneath":
            self._rug(host, near)
            return
        item = self._stock.draw(near.what)
        for _ in range(self._count(near.count)):
            if item is not None:
                placed = stand_near(self._draft, host, item, near.where, near.gap_m)
                if near.needed and placed is None:
                    self._missing.append(near.what)
                item = self._stock.again(item)

    def _scatter(self, small: Small, host: Thing, count: int) -> None:
        names = list(small.what)
        self._rng.shuffle(names)
        for name in names if count < len(names) else small.what:
            if count == 0:
                return
            count -= self._put(name, host, small)

    def _put(self, name: str, host: Thing, small: Small) -> bool:
        item = self._stock.draw(name)
        if item is None:
            return False
        found = put(
            item.mesh, host, self._draft.furniture(), self._rng,
            small.where, small.relation, small.straight,
        )  # fmt: skip
        if found is None:
            return False
        spot, relation = found
        self._draft.add(item, spot.T_world_thing, host.id, relation)
        return True

    def _floor(self, plan: Plan) -> None:
        names = list(plan.floor)
        self._rng.shuffle(names)
        wanted = self._count(plan.floor_count)
        for name in names:
            item = self._stock.draw(name) if wanted else None
            if item is not None:
                wanted -= stand_anywhere(self._draft, item, at_wall=True) is not None

    def _rug(self, host: Thing, near: Near) -> None:
        """Spread a rug in front of a piece, partly under it."""
        for _ in range(self._count(near.count)):
            spread_rug(self._draft, self._stock, host)

    def _row(self, row: Row) -> bool:
        return stand_row(self._draft, self._stock, row) is not None
