"""Copies of what mapping, views and encoding tell, and one number for each of them."""

import hashlib
from collections.abc import Iterable, Mapping
from typing import Any

from sceneq_core.mapping.delta import REMOVED
from sceneq_core.mapping.replica import MapReplica
from sceneq_nodes._convert import map_delta_from_message
from sceneq_schemas.codec import encode
from sceneq_schemas.feature import Descriptor, FeatureDelta
from sceneq_schemas.map import Instance, MapDelta
from sceneq_schemas.view import ViewDelta, ViewSet

DIGITS = 16


class MirroredMap:
    """Voxels and instances."""

    def __init__(self) -> None:
        self._replica = MapReplica()
        self._instances: dict[int, Instance] = {}

    def apply(self, delta: MapDelta) -> None:
        """Take over a change; raise ``ValueError``, unchanged, when it fits no map."""
        self._replica.apply(map_delta_from_message(delta))
        if delta.full:
            self._instances = {}
        for instance in delta.instances:
            self._instances[instance.instance_id] = instance
            if instance.state == REMOVED:
                del self._instances[instance.instance_id]

    def counts(self) -> dict[str, int]:
        """Return how much there is."""
        voxels = int(self._replica.alive.sum())
        return {"voxels": voxels, "instances": len(self._instances)}

    def digest(self) -> str:
        """Return a number that is equal for equal voxels, colours, owners and instances."""
        columns = self._replica.cloud()
        return _digest((column.tobytes() for column in columns), _by_id(self._instances))


class MirroredViews:
    """The view sets."""

    def __init__(self) -> None:
        self._sets: dict[int, ViewSet] = {}

    def apply(self, delta: ViewDelta) -> None:
        """Take over a change."""
        if delta.full:
            self._sets = {}
        for one in delta.view_sets:
            self._sets[one.instance_id] = one
            if not one.views:
                del self._sets[one.instance_id]

    def counts(self) -> dict[str, int]:
        """Return how much there is."""
        return {"view_sets": len(self._sets)}

    def digest(self) -> str:
        """Return a number that is equal for equal views."""
        return _digest(_by_id(self._sets))


class MirroredFeatures:
    """The descriptors."""

    def __init__(self) -> None:
        self._descriptors: dict[int, Descriptor] = {}

    def apply(self, delta: FeatureDelta) -> None:
        """Take over a change."""
        if delta.full:
            self._descriptors = {}
        for instance_id in delta.removed.tolist():
            self._descriptors.pop(instance_id, None)
        self._descriptors |= {one.instance_id: one for one in delta.descriptors}

    def counts(self) -> dict[str, int]:
        """Return how much there is."""
        return {"descriptors": len(self._descriptors)}

    def digest(self) -> str:
        """Return a number that is equal for equal descriptors."""
        return _digest(_by_id(self._descriptors))


def _by_id(items: Mapping[int, Any]) -> Iterable[bytes]:
    return (encode(items[item]) for item in sorted(items))


def _digest(*parts: Iterable[bytes]) -> str:
    digest = hashlib.sha256()
    for part in parts:
        for data in part:
            digest.update(data)
    return digest.hexdigest()[:DIGITS]
