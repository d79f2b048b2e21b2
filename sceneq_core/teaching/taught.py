"""A name that somebody gave to an instance."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64
from sceneq_core.mapping.delta import Instance


@dataclass(frozen=True, slots=True, eq=False)
class Spot:
    """Which instance of which map it is, and where: ``centre_world`` (3,), ``aabb_world`` (2, 3),
    metres.
    """

    instance_id: int
    map_epoch: int
    centre_world: Float64
    aabb_world: Float64

    @classmethod
    def of(cls, instance: Instance, map_epoch: int) -> "Spot":
        """Return where ``instance`` is in the map of ``map_epoch``."""
        centre, box = instance.centre_world.copy(), instance.aabb_world.copy()
        return cls(instance.instance_id, map_epoch, centre, box)


@dataclass(frozen=True, slots=True, eq=False)
class Looks:
    """What an instance looks like to the encoder ``model_id``.

    ``descriptor`` float32 (D,) of length 1; ``feature`` float32 (F,), the raw image feature, empty
    where the encoder has none.
    """

    model_id: str
    descriptor: Float32
    feature: Float32

    @property
    def image(self) -> Float32:
        """What look-alikes are compared by, float32 of length 1: the feature if there is one.

        The descriptor is made to be compared with words, and knows the words it was made for best.
        """
        vector = self.feature if len(self.feature) else self.descriptor
        length = float(np.linalg.norm(vector))
        return vector / np.float32(length) if length > 0 else vector


@dataclass(frozen=True, slots=True, eq=False)
class Taught:
    """``name``, of ``kind``, was given by ``by`` at ``stamp_ns`` (UTC) to what is at ``spot``.

    ``number`` counts what was ever taught in this scene; a higher one is newer.
    """

    number: int
    name: str
    kind: str
    by: str
    stamp_ns: int
    spot: Spot
    looks: Looks

    @property
    def told(self) -> str:
        """Who gave the name, and when."""
        return f"taught by {self.by} on {when(self.stamp_ns)}"


def when(stamp_ns: int) -> str:
    """Return a time such as 2026-11-22 14:05 UTC."""
    minute = np.datetime_as_string(np.datetime64(stamp_ns, "ns"), unit="m")
    return f"{str(minute).replace('T', ' ')} UTC"
