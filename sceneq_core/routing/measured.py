"""Descriptors that take account of how large their things are, as the map measures them."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.encoding.usual_sizes import shape_of
from sceneq_core.mapping.delta import FLOOR, Instance
from sceneq_core.routing.described import Described, describe
from sceneq_core.routing.labels import Labeller

STEP = 0.05
"""Shapes are rounded to steps of 5 % and 5 cm: what is said of a thing should not change with
every voxel."""


class Ground:
    """How high the floor is: the largest floor the map knows, or else the lowest thing in it."""

    def __init__(self) -> None:
        self._floors: dict[int, tuple[int, float]] = {}
        self._lowest_m = np.inf

    def clear(self) -> None:
        """Forget everything."""
        self._floors, self._lowest_m = {}, np.inf

    def see(self, instances: Iterable[Instance], up_world: Float64) -> None:
        """Take over changed instances."""
        for one in instances:
            self._floors.pop(one.instance_id, None)
            if one.role == FLOOR:
                height = float(one.centre_world @ up_world)
                self._floors[one.instance_id] = (one.voxel_count, height)
            self._lowest_m = min(self._lowest_m, _extent(one, up_world)[0])

    @property
    def height_m(self) -> float:
        """Height along "up" of the floor, rounded; 0 in an empty map."""
        lowest = self._lowest_m if np.isfinite(self._lowest_m) else 0.0
        height = max(self._floors.values())[1] if self._floors else lowest
        return round(height / STEP) * STEP


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """What ``described`` was made of."""

    bare: Described
    instance: Instance
    shape: Float64
    described: Described


class Measured:
    """Describes things by descriptor and size; remembers it while neither changes."""

    def __init__(self, labeller: Labeller) -> None:
        self._labeller = labeller
        self._ground = Ground()
        self._up_world: Float64 = np.array([0.0, 0.0, 1.0])
        self._ground_m = 0.0
        self._known: dict[int, _Known] = {}

    def see(self, instances: Iterable[Instance], up_world: Float64, *, full: bool) -> bool:
        """Take over changed instances; return whether all things now stand higher or lower."""
        if full:
            self._ground.clear()
        self._ground.see(instances, up_world)
        ground_m = self._ground.height_m
        moved = ground_m != self._ground_m or not np.array_equal(up_world, self._up_world)
        if moved or full:
            self._known = {}
        self._up_world, self._ground_m = up_world, ground_m
        return moved

    def of(self, bare: Described, instance: Instance) -> Described:
        """Return ``bare`` given the size of its instance, the same object while nothing changes."""
        known = self._known.get(instance.instance_id)
        if known is not None and known.bare is bare and known.instance is instance:
            return known.described
        shape = _shape(instance, self._up_world, self._ground_m)
        if known is not None and known.bare is bare and np.array_equal(known.shape, shape):
            described = known.described
        else:
            described = self._sized(bare, shape)
        self._known[instance.instance_id] = _Known(bare, instance, shape, described)
        return described

    def forget(self, instance_id: int) -> None:
        """It is gone."""
        self._known.pop(instance_id, None)

    def _sized(self, bare: Described, shape: Float64) -> Described:
        descriptor: Float32 = self._labeller.sized(bare.descriptor, shape)
        if descriptor is bare.descriptor:
            return bare
        return describe(descriptor, self._labeller, bare.familiarity)


def _shape(instance: Instance, up_world: Float64, ground_m: float) -> Float64:
    """Return the shape (4,) of an instance, in steps; its box need not stand upright."""
    low, high = _extent(instance, up_world)
    uprightness = np.abs(instance.T_world_box[:3, :3].T @ up_world)
    level = np.argsort(uprightness, kind="stable")[:2]
    sides = instance.box_size_m[level].tolist()
    return np.round(shape_of(sides, high - low, low - ground_m) / STEP) * STEP


def _extent(instance: Instance, up_world: Float64) -> tuple[float, float]:
    """Return lowest and highest point of the box along "up", metres."""
    R_world_box = instance.T_world_box[:3, :3]
    reach = float(np.abs(R_world_box.T @ up_world) @ instance.box_size_m) / 2
    middle = float(instance.T_world_box[:3, 3] @ up_world)
    return middle - reach, middle + reach
