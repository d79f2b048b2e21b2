"""The public life of instances: which groups of superpoints are known under which ids."""

from collections.abc import Callable
from dataclasses import dataclass, field

from sceneq_core.arrays import Float64
from sceneq_core.checks import need_at_least
from sceneq_core.mapping.association import GroupChange
from sceneq_core.mapping.boxes import box_around
from sceneq_core.mapping.chronicle import Chronicle
from sceneq_core.mapping.delta import CONFIRMED, TENTATIVE, Event, Instance
from sceneq_core.mapping.doubt import DoubtParams
from sceneq_core.mapping.lifecycle import UNKNOWN, Life
from sceneq_core.mapping.members import Members
from sceneq_core.mapping.presence import Look, Presence
from sceneq_core.mapping.recognition import Appearance, Recognition, RecognitionParams, Vanished
from sceneq_core.mapping.signature import signature_of
from sceneq_core.mapping.vanishing import Gone, Vanishing

_LOOKS_AGAIN = 1.25
"""The looks of an instance are taken again when its size changed by this factor."""


@dataclass(frozen=True, slots=True)
class RegistryParams:
    """What a group needs to be an instance, and to be a confirmed one.

    ``min_voxels`` make it an instance, half as many keep it one. It is confirmed by ``min_views``
    keyframes over ``min_s`` seconds that nothing contradicts.
    """

    min_views: int = 2
    min_s: float = 0.15
    min_voxels: int = 30
    doubt: DoubtParams = field(default_factory=DoubtParams)
    recognition: RecognitionParams = field(default_factory=RecognitionParams)

    def __post_init__(self) -> None:
        need_at_least(self, 1, "min_views", "min_voxels")
        need_at_least(self, 0, "min_s")


class Registry:
    """Gives ids from 1, in the order in which groups become instances, and never twice.

    In every keyframe first ``look``, then ``update``. docs/adr/0013-a-room-that-changes.md tells
    the states and what leads from one to another.
    """

    def __init__(self, params: RegistryParams, presence: Presence) -> None:
        self._params = params
        self._presence = presence
        self._recognition = Recognition(params.recognition)
        self._chronicle = Chronicle()
        self._vanishing = Vanishing(params.doubt, presence, self._recognition, self._chronicle)
        self._lives: dict[int, Life] = {}
        self._looks_size: dict[int, int] = {}
        self._next_id = 1

    @property
    def instances(self) -> dict[int, Instance]:
        """Those that are not removed, by id, as last returned by ``update``."""
        return self._chronicle.instances

    def look(self, look: Look, members: Callable[[int], Members]) -> Gone:
        """Hold what a keyframe looks through against the instances; return what is gone."""
        self._chronicle.now_ns = look.now_ns
        return self._vanishing.look(look, self._lives, members)

    def update(
        self,
        change: GroupChange,
        members: Callable[[int], Members],
        stamp_ns: int,
        up_world: Float64,
    ) -> tuple[tuple[Instance, ...], tuple[Event, ...]]:
        """Follow the groups of one keyframe; return the instances that differ, and the events."""
        self._chronicle.now_ns = max(self._chronicle.now_ns, stamp_ns)
        self._see(change)
        for source, target in change.merged:
            self._merge(source, target)
        for group in change.changed.tolist():
            self._follow(group, members(group), up_world)
        for instance_id, vanished in self._recognition.decide(self._chronicle.now_ns):
            self._recognise(instance_id, vanished)
        return self._chronicle.take()

    def _see(self, change: GroupChange) -> None:
        now_ns = self._chronicle.now_ns
        for group, parent in change.founded:
            origin = self._lives.get(parent)
            parent_id = origin.instance_id if origin else 0
            self._lives[group] = Life(now_ns, now_ns, now_ns, now_ns, parent_id)
        for group in change.seen.tolist():
            life = self._lives[group]
            if not (life.doubt and life.doubt.last_ns == now_ns):
                life.see(now_ns)

    def _merge(self, source: int, target: int) -> None:
        """Let ``target`` go on as both groups; one id ends as merged."""
        kept = self._lives[target]
        given_up = kept.absorb(self._lives.pop(source))
        if given_up:
            self._chronicle.end(given_up, "merged", merged_into=kept.instance_id)
            self._recognition.forget(given_up)

    def _follow(self, group: int, members: Members, up_world: Float64) -> None:
        life = self._lives.get(group)
        if life is None:
            return
        if not len(members.superpoint_id):
            del self._lives[group]
        if self._is_instance(life, len(members.voxel_id)):
            self._promote(life)
            self._describe(life, members, up_world)
        elif life.state != UNKNOWN:
            self._chronicle.end(life.instance_id, "removed")
            self._recognition.forget(life.instance_id)
            life.disown()

    def _is_instance(self, life: Life, voxels: int) -> bool:
        """Tell whether a group is an instance; it is harder to become one than to stay one."""
        known = life.state != UNKNOWN
        return (2 * voxels if known else voxels) >= self._params.min_voxels

    def _promote(self, life: Life) -> None:
        """Let a group become an instance, and a tentative instance a confirmed one."""
        now_ns = self._chronicle.now_ns
        if life.state == UNKNOWN:
            life.instance_id, self._next_id = self._next_id, self._next_id + 1
            life.enter(TENTATIVE, now_ns)
            self._chronicle.tell("appeared", life.instance_id)
            if life.parent:
                self._chronicle.tell("split", life.instance_id, life.parent)
        lasted = life.last_seen_ns - life.settled_ns >= self._params.min_s * 1e9
        if life.state == TENTATIVE and lasted and life.views >= self._params.min_views:
            life.enter(CONFIRMED, now_ns)
            self._chronicle.tell("confirmed", life.instance_id)

    def _describe(self, life: Life, members: Members, up_world: Float64) -> None:
        box = box_around(members.points_world, up_world)
        instance = Instance(
            instance_id=life.instance_id,
            state=life.state,
            merged_into=0,
            parent=life.parent,
            superpoint_id=members.superpoint_id,
            voxel_count=len(members.points_world),
            centre_world=box.centre_world,
            aabb_world=box.aabb_world,
            T_world_box=box.T_world_box,
            box_size_m=box.box_size_m,
            first_seen_ns=life.first_seen_ns,
            last_seen_ns=life.last_seen_ns,
            state_since_ns=life.state_since_ns,
            places=life.places,
        )
        self._chronicle.write(instance)
        if life.state == CONFIRMED and not life.doubt:
            self._note_looks(instance, members, up_world)

    def _note_looks(self, instance: Instance, members: Members, up_world: Float64) -> None:
        """Take the looks of an instance, again when its size has changed much."""
        key, count = instance.instance_id, instance.voxel_count
        before = self._looks_size.get(key, 0) if self._recognition.knows(key) else 0
        if count >= _LOOKS_AGAIN * before or before >= _LOOKS_AGAIN * count:
            self._looks_size[key] = count
            signature = signature_of(members.points_world, members.rgb, up_world)
            born_ns = self._presence.born_ns(members.voxel_id)
            self._recognition.see(key, Appearance(signature, born_ns))

    def _recognise(self, instance_id: int, vanished: Vanished) -> None:
        """Let an instance go on as the one that vanished elsewhere."""
        last, looks = vanished.instance, self._chronicle.instances[instance_id]
        life = next(one for one in self._lives.values() if one.instance_id == instance_id)
        life.resume(last, vanished.placed_ns)
        self._recognition.recognise(instance_id, last.instance_id)
        self._looks_size[last.instance_id] = self._looks_size.pop(instance_id)
        self._chronicle.unsay(last.instance_id)
        self._chronicle.end(instance_id, "merged", merged_into=last.instance_id)
        self._chronicle.enter(life, CONFIRMED, "moved", looks)
