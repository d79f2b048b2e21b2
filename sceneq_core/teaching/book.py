"""The names that were taught in a scene, and which instances they stick to."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from sceneq_core.checks import need_at_least, need_between, need_within
from sceneq_core.mapping.delta import REMOVED, Instance
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.teaching.album import Album
from sceneq_core.teaching.finding import find_again, instance_in
from sceneq_core.teaching.taught import Looks, Spot, Taught
from sceneq_core.teaching.wording import INDIVIDUAL, spoken

MAX_NAMES = 1000


@dataclass(frozen=True, slots=True)
class BookParams:
    """``certainty``: p of a name that somebody gave; people err too.

    When the map starts again, ids mean nothing: what was taught is the instance most probably the
    same by place and looks. With ``min_again`` it is shown as that, with ``sure_again`` it is
    written down. ``moved_m``: how far a thing moves until its new place is written down, metres.
    ``min_alike``: what a look-alike needs to inherit the name of a category; from ``maybe_alike``
    on it is counted as possibly one and ranked behind.
    """

    certainty: float = 0.99
    min_again: float = 0.5
    sure_again: float = 0.9
    moved_m: float = 0.2
    min_alike: float = 0.5
    maybe_alike: float = 0.1

    def __post_init__(self) -> None:
        need_between(self, 0, 1, "certainty")
        need_within(self, 0, 1, "min_again", "sure_again", "min_alike", "maybe_alike")
        need_at_least(self, 0, "moved_m")


@dataclass(frozen=True, slots=True)
class Held:
    """A name is that of ``instance_id``, with probability ``p`` that it is the one taught."""

    instance_id: int
    p: float = 1.0


class NameBook:
    """Keeps names by number; a name follows its instance through merges, moves and new maps.

    Not for several threads at once.
    """

    def __init__(self, params: BookParams) -> None:
        self.params = params
        self._taught: dict[int, Taught] = {}
        self._held: dict[int, Held] = {}
        self._moved: set[int] = set()
        self._seen_anew: set[int] = set()
        self._next = 1

    @property
    def taught(self) -> tuple[Taught, ...]:
        """All names, the oldest first."""
        return tuple(self._taught.values())

    @property
    def next_number(self) -> int:
        """The number of the next name."""
        return self._next

    def held(self, taught: Taught) -> Held | None:
        """Return the instance that a name is of; ``None`` = unattached, as of the last settling."""
        return self._held.get(taught.number)

    def replaced_by(self, new: Taught) -> tuple[Taught, ...]:
        """Return the names that a new one takes the place of.

        A name of an individual is that of one thing; a category may be taught with many. The same
        words are never both.

        Raises:
            ValueError: ``MAX_NAMES`` are taught already.
        """
        replaced = tuple(one for one in self.taught if _replaces(new, one))
        if len(self._taught) - len(replaced) >= MAX_NAMES:
            raise ValueError(f"name: {MAX_NAMES} are taught already, forget one first")
        return replaced

    def teach(self, new: Taught) -> None:
        """Add a name; raises ``ValueError`` as ``replaced_by``."""
        self.forget(self.replaced_by(new))
        self.recall(new)
        self._held[new.number] = Held(new.spot.instance_id)

    def recall(self, one: Taught) -> None:
        """Add a name of an earlier run; the next settling finds its instance."""
        self._taught[one.number] = one
        self._next = max(self._next, one.number + 1)

    def called(self, name: str) -> tuple[Taught, ...]:
        """Return what was taught with the words of ``name``."""
        return tuple(one for one in self.taught if spoken(one.name) == spoken(name))

    def names_of(self, instance_id: int) -> tuple[Taught, ...]:
        """Return the names that an instance has."""
        held = ((one, self.held(one)) for one in self.taught)
        return tuple(one for one, at in held if at and at.instance_id == instance_id)

    def forget(self, names: Iterable[Taught]) -> None:
        """Take names back."""
        for one in names:
            del self._taught[one.number]
            self._held.pop(one.number, None)
            self._moved.discard(one.number)
            self._seen_anew.discard(one.number)

    def follow(self, map_epoch: int, instances: Iterable[Instance]) -> None:
        """Stick to what an instance was merged into."""
        if not self._taught:
            return
        into = {
            one.instance_id: one.merged_into
            for one in instances
            if one.state == REMOVED and one.merged_into
        }
        for one in self.taught:
            target = _last(into, one.spot.instance_id)
            if one.spot.map_epoch == map_epoch and target != one.spot.instance_id:
                self._stand(one, replace(one.spot, instance_id=target))

    def settle(self, snapshot: SceneSnapshot, album: Album) -> None:
        """Find the instance of every name in the map as it is now."""
        epoch = snapshot.revision.epoch
        for one in self.taught:
            same_map = one.spot.map_epoch == epoch
            instance = instance_in(snapshot, one.spot.instance_id) if same_map else None
            p = 1.0
            if instance is None and len(snapshot):
                instance, p = find_again(one, snapshot, album)
            self._hold(one, instance, p)
            if instance is not None and p >= self.params.sure_again:
                self._move(one, Spot.of(instance, epoch))
                self._look_anew(one.number, album.looks_of(instance.instance_id))

    def take_moved(self) -> tuple[Taught, ...]:
        """Return the names whose instance or place changed since the last call."""
        return self._take(self._moved)

    def take_seen_anew(self) -> tuple[Taught, ...]:
        """Return the names whose looks are those of another encoder since the last call."""
        return self._take(self._seen_anew)

    def _take(self, numbers: set[int]) -> tuple[Taught, ...]:
        changed = tuple(self._taught[number] for number in sorted(numbers))
        numbers.clear()
        return changed

    def _hold(self, one: Taught, instance: Instance | None, p: float) -> None:
        if instance is None or p < self.params.min_again:
            self._held.pop(one.number, None)
        else:
            self._held[one.number] = Held(instance.instance_id, p)

    def _move(self, one: Taught, spot: Spot) -> None:
        """Write down a new instance at once, a new place when it is far enough."""
        far_m = abs(spot.centre_world - one.spot.centre_world).max()
        same = (spot.instance_id, spot.map_epoch) == (one.spot.instance_id, one.spot.map_epoch)
        if not same or far_m > self.params.moved_m:
            self._stand(one, spot)

    def _stand(self, one: Taught, spot: Spot) -> None:
        self._taught[one.number] = replace(one, spot=spot)
        self._moved.add(one.number)

    def _look_anew(self, number: int, looks: Looks | None) -> None:
        """After a change of the encoder, know what was taught as the new one sees it."""
        one = self._taught[number]
        if looks is not None and looks.model_id != one.looks.model_id:
            self._taught[number] = replace(one, looks=looks)
            self._seen_anew.add(number)


def _replaces(new: Taught, old: Taught) -> bool:
    if spoken(new.name) != spoken(old.name):
        return False
    where = (new.spot.map_epoch, new.spot.instance_id)
    here = where == (old.spot.map_epoch, old.spot.instance_id)
    return here or INDIVIDUAL in (new.kind, old.kind)


def _last(into: dict[int, int], instance_id: int) -> int:
    """Follow merges to their end; each is followed once, whatever the table says."""
    for _ in into:
        if instance_id not in into:
            break
        instance_id = into[instance_id]
    return instance_id
