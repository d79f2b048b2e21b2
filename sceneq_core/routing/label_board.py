"""What every instance is called, kept up with the scene."""

from collections.abc import Iterable
from dataclasses import dataclass

from sceneq_core.mapping.delta import OBJECT
from sceneq_core.routing.answer import FOUND, Naming
from sceneq_core.routing.labels import Label
from sceneq_core.routing.namer import Namer
from sceneq_core.routing.scene import SceneInstance, SceneSnapshot


@dataclass(frozen=True, slots=True)
class InstanceLabel:
    """The name of an instance with its probability; ``accepted``: the gate lets it pass.

    ``source`` is that of ``Label``.
    """

    instance_id: int
    name: str
    p: float
    accepted: bool
    source: str


@dataclass(frozen=True, slots=True)
class LabelChanges:
    """Names that are new or other than before, by id, and the ids that have none any more."""

    labels: tuple[InstanceLabel, ...]
    removed: tuple[int, ...]

    def __bool__(self) -> bool:
        return bool(self.labels or self.removed)


class LabelBoard:
    """Names all instances; works out only those whose label changed.

    A reasoner's name stands until the label that it was put in place of changes.
    """

    def __init__(self, namer: Namer) -> None:
        self._namer = namer
        self._given: dict[int, Label] = {}
        self._named: dict[int, InstanceLabel] = {}
        self._told: dict[int, tuple[Label, InstanceLabel]] = {}

    def tell(self, naming: Naming) -> None:
        """Take over what a reasoner calls an instance; may be called from any thread."""
        best, instance_id = naming.labels[0], naming.instance.instance_id
        accepted = naming.status == FOUND
        told = InstanceLabel(instance_id, best.name, best.p, accepted, best.source)
        self._told[instance_id] = (naming.instance.label, told)

    def update(self, snapshot: SceneSnapshot) -> LabelChanges:
        """Return what is called otherwise since the last update."""
        given = {one.instance_id: one.label for one in snapshot.instances}
        told = dict(self._told)
        new = [
            self._name(snapshot, row, one)
            for row, one in enumerate(snapshot.instances)
            if self._given.get(one.instance_id) != one.label or one.instance_id in told
        ]
        changed = [one for one in new if self._named.get(one.instance_id) != one]
        removed = sorted(self._given.keys() - given.keys())
        self._given = given
        self._forget(removed)
        self._named |= {one.instance_id: one for one in changed}
        return LabelChanges(tuple(changed), tuple(removed))

    def all(self) -> tuple[InstanceLabel, ...]:
        """Return the names of all instances, by id."""
        return tuple(self._named[key] for key in sorted(self._named))

    def _forget(self, removed: Iterable[int]) -> None:
        for instance_id in removed:
            self._named.pop(instance_id, None)
            self._told.pop(instance_id, None)

    def _name(self, snapshot: SceneSnapshot, row: int, one: SceneInstance) -> InstanceLabel:
        """A part of the building is what the map says it is."""
        replaced, told = self._told.get(one.instance_id, (None, None))
        if told is not None and replaced == one.label:
            return told
        self._told.pop(one.instance_id, None)
        accepted = one.geometry.role != OBJECT or self._namer.accepts(snapshot, row)
        label = one.label
        return InstanceLabel(one.instance_id, label.name, label.p, accepted, label.source)
