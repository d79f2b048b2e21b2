"""Where an instance is, in terms of other things: what it rests on, and the nearest landmark."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.mapping.delta import OBJECT
from sceneq_core.reasoning.english import metres
from sceneq_core.routing.scene import SceneInstance, SceneSnapshot

LEAST_LARGER = 2.0
"""A landmark has at least this multiple of the volume: one finds a cup by the sink."""


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """``relation`` is "on" or "in" ``support``; ``landmark`` is ``distance_m`` from its box."""

    relation: str
    support: SceneInstance | None
    landmark: SceneInstance | None
    distance_m: float

    def said(self) -> str:
        """Return such as "on the table, 0.40 m from the sink"; "" when there is nothing to say."""
        parts = []
        if self.support is not None:
            parts.append(f"{self.relation} the {self.support.label.name}")
        if self.landmark is not None:
            name = self.landmark.label.name
            touches = self.distance_m < 0.05
            parts.append(
                f"at the {name}" if touches else f"{metres(self.distance_m)} from the {name}"
            )
        return ", ".join(parts)


def whereabouts(snapshot: SceneSnapshot, instance: SceneInstance) -> Whereabouts:
    """Return where ``instance`` is; what is gone is placed by what is still there."""
    relation, support = _support(snapshot, instance)
    row, distance_m = _landmark(snapshot, instance, support)
    landmark = None if row is None else snapshot.instances[row]
    return Whereabouts(relation, support, landmark, distance_m)


def _support(snapshot: SceneSnapshot, instance: SceneInstance) -> tuple[str, SceneInstance | None]:
    holders = (("in", instance.geometry.inside), ("on", instance.geometry.supported_by))
    for relation, instance_id in holders:
        row = snapshot.find(instance_id) if instance_id else None
        if row is not None:
            return relation, snapshot.instances[row]
    return "", None


def _landmark(
    snapshot: SceneSnapshot, instance: SceneInstance, support: SceneInstance | None
) -> tuple[int | None, float]:
    """Return the row of the nearest clearly larger object that does not hold it, and how far."""
    boxes, own = snapshot.columns.aabb_world, instance.geometry
    edges = boxes[:, 1] - boxes[:, 0]
    larger = edges.prod(axis=1) >= LEAST_LARGER * np.prod(own.aabb_world[1] - own.aabb_world[0])
    held = [own.instance_id, *([support.instance_id] if support else [])]
    usable = larger & (snapshot.columns.role == OBJECT)
    usable &= ~np.isin(snapshot.columns.instance_id, held)
    if not usable.any():
        return None, 0.0
    apart = np.maximum(boxes[:, 0] - own.aabb_world[1], own.aabb_world[0] - boxes[:, 1])
    gaps = np.where(usable, np.linalg.norm(np.maximum(apart, 0.0), axis=1), np.inf)
    row = int(gaps.argmin())
    return row, float(gaps[row])
