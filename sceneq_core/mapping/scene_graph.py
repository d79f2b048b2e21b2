"""What instances are to the room and to each other: structure, support, containment, closeness."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from sceneq_core.arrays import Float64, Int32
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.mapping.boxes import level_axes
from sceneq_core.mapping.delta import CEILING, FLOOR, OBJECT, REMOVED, WALL, Instance
from sceneq_core.mapping.patches import Patches
from sceneq_core.mapping.relating import Surroundings, carrier_of
from sceneq_core.mapping.shape import NO_SHAPE, Shape, crowd_of, shape_of, within_reach
from sceneq_core.mapping.structure import NO_PLANE, Structure, StructureParams
from sceneq_core.mapping.superpoints import Superpoints
from sceneq_core.mapping.support import SupportParams, WallShape, beside
from sceneq_core.mapping.voxels import Voxels


@dataclass(frozen=True, slots=True)
class SceneGraphParams:
    """When relations are worked out again.

    An instance is looked at again when a side of its box moved by ``moved_m`` or it has ``grown``
    by this share, and what is beside it too when the side moved by ``moved_far_m``; at most
    ``per_keyframe`` are related in a keyframe, oldest first. The frame it is done in turns when up
    does by ``turned_deg``.
    """

    moved_m: float = 0.03
    grown: float = 0.1
    moved_far_m: float = 0.1
    turned_deg: float = 0.3
    per_keyframe: int = 6
    structure: StructureParams = field(default_factory=StructureParams)
    support: SupportParams = field(default_factory=SupportParams)

    def __post_init__(self) -> None:
        need_positive(self, "moved_m", "grown", "moved_far_m", "turned_deg")
        need_at_least(self, 1, "per_keyframe")


@dataclass(slots=True)
class _Member:
    """An instance in the graph.

    ``measured`` is the instance as its ``shape`` shows it; ``related_box`` (2, 3) its box when its
    relations were last worked out.
    """

    instance: Instance
    measured: Instance
    shape: Shape = NO_SHAPE
    plane: int = NO_PLANE
    role: str = OBJECT
    supported_by: int = 0
    inside: int = 0
    beside: set[int] = field(default_factory=set)
    related_box: Float64 | None = None


class SceneGraph:
    """Adds role and relations to the instances as they change, and only round what changed.

    Attributes:
        instances: the active ones by id, as last returned by ``update``.
    """

    def __init__(self, params: SceneGraphParams, voxel_size_m: float) -> None:
        self._params = params
        self._patches = Patches()
        self._structure = Structure(params.structure, voxel_size_m)
        self._members: dict[int, _Member] = {}
        self._due: dict[int, None] = {}
        self._floor_id = 0
        self._R_level_world = np.eye(3)
        self._boxes = _boxes_of(self._members)
        self.instances: dict[int, Instance] = {}

    def up_world(self, estimate_world: Float64) -> Float64:
        """Return up as the floor tells it, far more precisely than the normals of an estimate."""
        floor = self._structure.floor
        return floor.normal_world if floor is not None else estimate_world

    def update(
        self,
        voxels: Voxels,
        superpoints: Superpoints,
        renewed_id: Int32,
        gone_id: Int32,
        news: Iterable[Instance],
        up_world: Float64,
    ) -> tuple[Instance, ...]:
        """Follow one change of the map; return the instances that differ, by id.

        ``renewed_id`` are the voxels of all superpoints that changed, ``gone_id`` the superpoints
        that ended, ``news`` the instances that changed, without role and relations.
        """
        changed_id = self._patches.update(voxels, superpoints, renewed_id, gone_id)
        anew = self._structure.update(self._patches, changed_id, up_world)
        turned = self._turn(self.up_world(up_world))
        news = tuple(news)
        self._forget([one for one in news if one.state == REMOVED])
        changed = [one.instance_id for one in news if one.state != REMOVED and self._take(one)]
        for number in self._members if turned else changed:
            self._measure(self._members[number])
        self._boxes = _boxes_of(self._members)
        recast = self._assign_roles(self._members if anew else changed)
        self._follow_floor()
        self._find_due(self._members if turned else [*changed, *recast])
        self._relate()
        return self._publish(news)

    def _turn(self, up_world: Float64) -> bool:
        """Turn the level frame when up has changed noticeably; return whether it has."""
        if self._R_level_world[2] @ up_world > np.cos(np.deg2rad(self._params.turned_deg)):
            return False
        self._R_level_world = level_axes(up_world).T
        return True

    def _take(self, instance: Instance) -> bool:
        """Take over an instance; return whether it changed enough to look at it again."""
        member = self._members.get(instance.instance_id)
        if member is None:
            self._members[instance.instance_id] = _Member(instance, instance)
            return True
        member.instance = instance
        then = member.measured
        grown = abs(instance.voxel_count - then.voxel_count) / max(then.voxel_count, 1)
        moved_m = np.abs(instance.aabb_world - then.aabb_world).max()
        return bool(grown >= self._params.grown or moved_m >= self._params.moved_m)

    def _forget(self, gone: Iterable[Instance]) -> None:
        """Take removed instances out; who leaned on one leans on what it merged into."""
        for instance in gone:
            number = instance.instance_id
            self._due.pop(number, None)
            if self._members.pop(number, None) is None:
                continue
            for other, member in self._members.items():
                if number in (member.supported_by, member.inside) or number in member.beside:
                    _lean(member, number, instance.merged_into)
                    self._due[other] = None

    def _measure(self, member: _Member) -> None:
        """Look at an instance again; one without any surface left keeps its last shape."""
        superpoint_id = member.instance.superpoint_id
        member.measured = member.instance
        present = superpoint_id[self._patches.voxels[superpoint_id] > 0]
        if len(present):
            member.shape = shape_of(self._patches, present, self._R_level_world)

    def _assign_roles(self, numbers: Iterable[int]) -> list[int]:
        """Tell structure from objects; return whose role is another one now."""
        recast = []
        for number in numbers:
            member = self._members[number]
            member.plane = self._structure.plane_of(self._patches, member.instance.superpoint_id)
            role = self._structure.role_of(member.plane)
            if role != member.role:
                member.role, member.related_box = role, None
                recast.append(number)
        return recast

    def _follow_floor(self) -> None:
        """Let one instance speak for the floor: the largest, until another is twice as large."""
        floors = {n: m.instance.voxel_count for n, m in self._members.items() if m.role == FLOOR}
        largest = max(floors, key=lambda n: (floors[n], -n), default=0)
        if self._floor_id in floors and 2 * floors[self._floor_id] >= floors[largest]:
            return
        for member in self._members.values():
            if self._floor_id and member.supported_by == self._floor_id:
                member.supported_by = largest
        self._floor_id = largest

    def _find_due(self, numbers: Iterable[int]) -> None:
        """Note who has to be related anew: who changed, and who is close to one that moved."""
        for number in numbers:
            member = self._members[number]
            box, then = member.shape.box, member.related_box
            member.related_box = box
            self._due[number] = None
            if then is None or np.abs(box - then).max() > self._params.moved_far_m:
                for place in (box,) if then is None else (box, then):
                    self._due.update(dict.fromkeys(self._touching(place)))

    def _touching(self, box: Float64) -> list[int]:
        near = self._near(box, self._params.support.reach_m)
        return [number for number in near if self._members[number].role == OBJECT]

    def _near(self, box: Float64, reach_m: float) -> list[int]:
        """Return the ids of the instances that come within ``reach_m`` of a level box (2, 3)."""
        numbers, boxes = self._boxes
        close = within_reach(boxes[:, 0], boxes[:, 1], box, reach_m)
        return [numbers[row] for row in np.flatnonzero(close)]

    def _relate(self) -> None:
        """Work out the relations of those that wait longest."""
        for number in list(self._due)[: self._params.per_keyframe]:
            del self._due[number]
            self._separate(number)
            if self._members[number].role == OBJECT:
                self._join(number)

    def _separate(self, number: int) -> None:
        """Take an instance out of all relations of its own."""
        member = self._members[number]
        for other in member.beside:
            if other in self._members:
                self._members[other].beside.discard(number)
        member.beside, member.supported_by, member.inside = set(), 0, 0

    def _join(self, number: int) -> None:
        """Find what carries an object, and link it with its neighbours in both directions."""
        member, params = self._members[number], self._params.support
        around = self._surroundings(number)
        member.supported_by, member.inside = carrier_of(member.shape, around, params)
        member.beside = beside(member.shape, around.crowd, params)
        for other in member.beside:
            self._members[other].beside.add(number)

    def _surroundings(self, number: int) -> Surroundings:
        members, floor, params = self._members, self._structure.floor, self._params.support
        box, carried = members[number].shape.box, self._carried(number)
        near = self._near(box, params.deep_m)
        beside_id = [n for n in self._near(box, params.beside_m) if n != number]
        objects = {n: members[n].shape for n in beside_id if members[n].role == OBJECT}
        return Surroundings(
            objects=objects,
            crowd=crowd_of(objects),
            carried=np.array([n in carried for n in objects], np.bool_),
            walls={n: self._wall(n) for n in near if members[n].role == WALL},
            ceilings={n: members[n].shape for n in near if members[n].role == CEILING},
            floor_id=self._floor_id,
            floor_m=floor.offset_m if floor is not None else -np.inf,
        )

    def _wall(self, number: int) -> WallShape:
        member = self._members[number]
        plane = self._structure.planes[member.plane].plane
        return WallShape(member.shape, self._R_level_world @ plane.normal_world, plane.offset_m)

    def _carried(self, number: int) -> set[int]:
        """Return what stands on an instance, directly or not: it cannot stand on that itself."""
        found: set[int] = set()
        fresh = {number}
        while fresh:
            fresh = {n for n, m in self._members.items() if m.supported_by in fresh} - found
            found |= fresh
        return found

    def _publish(self, news: tuple[Instance, ...]) -> tuple[Instance, ...]:
        """Return what is new by itself or by its relations, and remember it as told."""
        told = {one.instance_id: one for one in news}
        for number, member in self._members.items():
            known = self.instances.get(number)
            if number in told or known is None or not _same(member, known):
                told[number] = self.instances[number] = _decorated(member)
        for number in told.keys() - self._members.keys():
            self.instances.pop(number, None)
        return tuple(told[number] for number in sorted(told))


def _lean(member: _Member, before: int, now: int) -> None:
    if member.supported_by == before:
        member.supported_by = now
    if member.inside == before:
        member.inside = now
    member.beside.discard(before)


def _boxes_of(members: Mapping[int, _Member]) -> tuple[list[int], Float64]:
    """Return the ids and the boxes float64 (N, 2, 3) of all members."""
    boxes = np.array([member.shape.box for member in members.values()])
    return list(members), boxes.reshape(-1, 2, 3)


def _same(member: _Member, known: Instance) -> bool:
    same = (member.role, member.supported_by, member.inside) == (
        known.role,
        known.supported_by,
        known.inside,
    )
    return same and sorted(member.beside) == known.neighbour_id.tolist()


def _decorated(member: _Member) -> Instance:
    return replace(
        member.instance,
        role=member.role,
        supported_by=member.supported_by,
        inside=member.inside,
        neighbour_id=np.array(sorted(member.beside), np.int32),
    )
