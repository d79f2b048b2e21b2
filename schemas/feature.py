"""What encoding writes: descriptors of instances in one encoder's space."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class Descriptor:
    """One instance in the encoder's joint space, L2-normalised, and its raw image feature."""

    instance_id: int
    view_seq: Annotated[Array, ArraySpec("<i8", (None,))]
    descriptor: Annotated[Array, ArraySpec("<f4", (None,))]
    feature: Annotated[Array, ArraySpec("<f4", (None,))]


@dataclass(frozen=True, slots=True)
class FeatureDelta:
    """Descriptors that changed since ``seq - 1`` of the same ``epoch``; all with ``full``.

    ``map_epoch`` names the map whose instances are described; a delta of another one is full.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.feat.v1"
    epoch: int
    seq: int
    full: bool
    frame_seq: int
    stamp_ns: int
    model_id: str
    descriptors: tuple[Descriptor, ...]
    removed: Annotated[Array, ArraySpec("<i4", (None,))]
    map_epoch: int = 0
