"""The life of an instance: what is known of a group of superpoints, and the state that gives."""

from dataclasses import dataclass

from sceneq_core.mapping.delta import CONFIRMED, STALE, TENTATIVE, Instance, Place
from sceneq_core.mapping.doubt import Doubt

UNKNOWN = ""
"""The state of a group that was not an instance yet."""

_RANK = {UNKNOWN: 0, TENTATIVE: 1, STALE: 2, CONFIRMED: 3}
_MOST_PLACES = 16


@dataclass(slots=True)
class Life:
    """What is known of a group; ``instance_id`` is 0 until it is an instance.

    ``views`` counts the keyframes that showed it since ``settled_ns``, when it was founded or last
    contradicted; it is where it is since ``placed_ns``.
    """

    first_seen_ns: int
    last_seen_ns: int
    settled_ns: int
    placed_ns: int
    parent: int = 0
    views: int = 0
    instance_id: int = 0
    state: str = UNKNOWN
    state_since_ns: int = 0
    places: tuple[Place, ...] = ()
    doubt: Doubt | None = None

    def see(self, stamp_ns: int) -> None:
        """Count a keyframe that shows the group."""
        self.views += 1
        self.last_seen_ns = max(self.last_seen_ns, stamp_ns)

    def enter(self, state: str, now_ns: int) -> None:
        """Change the state."""
        self.state, self.state_since_ns = state, now_ns

    def unsettle(self, now_ns: int) -> None:
        """Count views anew: what is contradicted has to be seen again before it is confirmed."""
        self.views, self.settled_ns = 0, now_ns

    def leave(self, instance: Instance, now_ns: int) -> None:
        """Remember the place where ``instance`` was."""
        place = Place(
            centre_world=instance.centre_world,
            aabb_world=instance.aabb_world,
            from_ns=self.placed_ns,
            until_ns=instance.last_seen_ns,
        )
        self.places = (*self.places, place)[-_MOST_PLACES:]
        self.placed_ns = now_ns

    def resume(self, vanished: Instance, placed_ns: int) -> None:
        """Go on as an instance that vanished from where it was since ``placed_ns``."""
        self.instance_id, self.parent = vanished.instance_id, vanished.parent
        self.places, self.placed_ns = vanished.places, placed_ns
        self.leave(vanished, self.first_seen_ns)
        self.first_seen_ns = vanished.first_seen_ns

    def disown(self) -> None:
        """Be no instance any more: too little is left."""
        self.state, self.instance_id, self.doubt = UNKNOWN, 0, None

    def absorb(self, other: "Life") -> int:
        """Go on as both; the id of the one known better stays. Return the id given up, or 0."""
        first, second = sorted((self, other), key=_standing)
        kept_id, given_up = first.instance_id, second.instance_id
        self.views = max(self.views, other.views)
        self.first_seen_ns = min(self.first_seen_ns, other.first_seen_ns)
        self.last_seen_ns = max(self.last_seen_ns, other.last_seen_ns)
        self.settled_ns = min(self.settled_ns, other.settled_ns)
        self.placed_ns, self.places, self.parent = first.placed_ns, first.places, first.parent
        self.instance_id, self.doubt = kept_id, None
        self.state, self.state_since_ns = first.state, first.state_since_ns
        return given_up


def _standing(life: Life) -> tuple[int, int]:
    return -min(_RANK[life.state], _RANK[STALE]), life.instance_id or 1 << 62
