"""The words in which a kind of room is described.

Furniture and things are named by a category's label, or by its role, which stands for any category
of that role. What the library does not have is left out.
"""

from dataclasses import dataclass

Range = tuple[float, float]
Count = tuple[int, int]


@dataclass(frozen=True, slots=True)
class Near:
    """A companion of a piece of furniture.

    Attributes:
        what: label or role.
        where: ``beside`` it at the same wall; ``ahead`` of it; ``tucked`` under it from the front,
            facing it; ``around`` it on all sides, facing it; ``aside``, in front and turned to
            what stands ahead; ``across``, at the opposite wall, facing it; ``beneath``, for rugs.
        count: how many, from and to.
        gap_m: free distance to the piece.
        needed: whether a room without it is drawn again.
    """

    what: str
    where: str
    count: Count = (1, 1)
    gap_m: float = 0.08
    needed: bool = False


@dataclass(frozen=True, slots=True)
class Piece:
    """Furniture with its companions.

    Attributes:
        what: label or role.
        where: ``wall``, anywhere along one; ``corner``, near the end of one; ``centre``, near the
            middle of one; ``middle`` of the room.
        count: how many, from and to.
        front_m: free floor in front of it that only its companions may use.
        near: companions, in the order in which they get their places.
        needed: whether a room without it is drawn again.
    """

    what: str
    where: str = "wall"
    count: Count = (1, 1)
    front_m: float = 0.55
    near: tuple[Near, ...] = ()
    needed: bool = False


@dataclass(frozen=True, slots=True)
class Above:
    """What hangs above part of a kitchen row, side by side.

    Attributes:
        what: label or role.
        bottom_m: height of its lower edge.
        over: roles of the furniture it hangs above.
    """

    what: str
    bottom_m: float
    over: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Row:
    """Kitchen furniture side by side along a wall.

    Attributes:
        base: labels or roles from left to right; those at the end are dropped on a short wall.
        optional: one of these may be put in at a random place.
        above: what hangs above them.
        tops: where the same model is repeated.
        front_m: free floor in front.
    """

    base: tuple[str, ...]
    optional: tuple[str, ...]
    above: tuple[Above, ...]
    tops: tuple[str, ...]
    front_m: float = 0.8


@dataclass(frozen=True, slots=True)
class Small:
    """Things that are put on, in or under furniture.

    Attributes:
        on: labels or roles of what they are put on, every one of them.
        what: labels or roles; each is taken at most once for one host, but may be listed twice.
        count: how many per host.
        where: ``anywhere``, ``centre``, ``back``, ``seats`` (the edges, where people sit).
        relation: ``on`` (inside, where the level is a shelf) or ``under``.
        straight: parallel to the host, or turned a little as things are.
    """

    on: tuple[str, ...]
    what: tuple[str, ...]
    count: Count
    where: str = "anywhere"
    relation: str = "on"
    straight: bool = False


@dataclass(frozen=True, slots=True)
class Plan:
    """One kind of room.

    Attributes:
        kind: one of ``KINDS``.
        width_m: from and to; ``depth_m`` too.
        windows: how many; ``pictures`` on the walls too.
        row: kitchen furniture, or ``None``.
        pieces: furniture in the order in which it gets its places: large before small.
        small: things on furniture, the characteristic ones first.
        floor: things that stand about; ``floor_count`` of them.
        things: the room is filled up with further small things until it has so many.
        hung: labels of what may hang on the walls beside pictures.
        floors: kinds of floor: ``planks``, ``tiles``, ``carpet``.
    """

    kind: str
    width_m: Range
    depth_m: Range
    windows: Count
    pictures: Count
    row: Row | None
    pieces: tuple[Piece, ...]
    small: tuple[Small, ...]
    floor: tuple[str, ...]
    floor_count: Count
    things: Count
    hung: tuple[str, ...] = ("wall clock", "cuckoo clock", "mirror", "dartboard")
    floors: tuple[str, ...] = ("planks",)
