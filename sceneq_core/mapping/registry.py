"""The public life of instances: when a group of superpoints gets an id, and when it ends."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from sceneq_core.arrays import Float32, Float64, Int32
from sceneq_core.checks import need_at_least
from sceneq_core.mapping.association import GroupChange
from sceneq_core.mapping.boxes import box_around
from sceneq_core.mapping.delta import CONFIRMED, REMOVED, Instance


@dataclass(frozen=True, slots=True)
class RegistryParams:
    """What a group needs to be an instance: ``min_views`` keyframes and ``min_voxels``.

    An instance that shrinks ends below half of ``min_voxels``.
    """

    min_views: int = 2
    min_voxels: int = 30

    def __post_init__(self) -> None:
        need_at_least(self, 1, "min_views", "min_voxels")


@dataclass(frozen=True, slots=True)
class Members:
    """What a group consists of now: ``superpoint_id`` sorted and ``points_world`` of its voxels."""

    superpoint_id: Int32
    points_world: Float32


@dataclass(slots=True)
class _Life:
    """What is known of a group: ``instance_id`` is 0 until it has been an instance."""

    views: int
    first_seen_ns: int
    last_seen_ns: int
    parent: int = 0
    instance_id: int = 0
    active: bool = False


class Registry:
    """Gives ids from 1, in the order in which groups become instances, and never twice.

    Attributes:
        instances: the active ones by id, as last returned by ``update``.
    """

    def __init__(self, params: RegistryParams) -> None:
        self._params = params
        self._lives: dict[int, _Life] = {}
        self._next_id = 1
        self.instances: dict[int, Instance] = {}

    def update(
        self,
        change: GroupChange,
        members: Callable[[int], Members],
        stamp_ns: int,
        up_world: Float64,
    ) -> tuple[Instance, ...]:
        """Follow the groups of one keyframe; return the instances that differ, by id."""
        news: dict[int, Instance] = {}
        self._see(change, stamp_ns)
        for source, target in change.merged:
            news |= self._merge(source, target)
        for group in change.changed.tolist():
            news |= self._follow(group, members(group), up_world)
        for instance_id, instance in news.items():
            if instance.state != REMOVED:
                self.instances[instance_id] = instance
            else:
                self.instances.pop(instance_id, None)
        return tuple(news[instance_id] for instance_id in sorted(news))

    def _see(self, change: GroupChange, stamp_ns: int) -> None:
        for group, parent in change.founded:
            origin = self._lives.get(parent)
            parent_id = origin.instance_id if origin else 0
            self._lives[group] = _Life(0, stamp_ns, stamp_ns, parent_id)
        for group in change.seen.tolist():
            life = self._lives[group]
            life.views += 1
            life.last_seen_ns = max(life.last_seen_ns, stamp_ns)

    def _merge(self, source: int, target: int) -> dict[int, Instance]:
        """Let ``target`` go on under the older id; the other id ends as merged."""
        gone, kept = self._lives.pop(source), self._lives[target]
        kept.views = max(kept.views, gone.views)
        kept.first_seen_ns = min(kept.first_seen_ns, gone.first_seen_ns)
        kept.last_seen_ns = max(kept.last_seen_ns, gone.last_seen_ns)
        ids = sorted(i for i in (kept.instance_id, gone.instance_id) if i)
        kept.active = kept.active or gone.active
        kept.instance_id = ids[0] if ids else 0
        last = self.instances.get(ids[-1]) if len(ids) == 2 else None
        return {ids[1]: replace(last, state=REMOVED, merged_into=ids[0])} if last else {}

    def _follow(self, group: int, members: Members, up_world: Float64) -> dict[int, Instance]:
        life = self._lives.get(group)
        if life is None:
            return {}
        active = self._qualifies(life, len(members.points_world))
        ended = life.active and not active
        life.active = active
        if not len(members.superpoint_id):
            del self._lives[group]
        if ended:
            last = self.instances[life.instance_id]
            return {life.instance_id: replace(last, state=REMOVED)}
        return self._describe(life, members, up_world) if active else {}

    def _qualifies(self, life: _Life, voxels: int) -> bool:
        """Tell whether a group is an instance; it is harder to become one than to stay one."""
        if life.active:
            return 2 * voxels >= self._params.min_voxels
        return life.views >= self._params.min_views and voxels >= self._params.min_voxels

    def _describe(self, life: _Life, members: Members, up_world: Float64) -> dict[int, Instance]:
        if not life.instance_id:
            life.instance_id = self._next_id
            self._next_id += 1
        box = box_around(members.points_world, up_world)
        instance = Instance(
            instance_id=life.instance_id,
            state=CONFIRMED,
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
        )
        return {life.instance_id: instance}
