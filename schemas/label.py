"""What routing writes besides answers: what every instance is called."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class InstanceLabel:
    """What one instance is called, with probability ``p``.

    ``accepted``: the gate lets the name pass. ``source`` is ``encoder``, ``reasoner``, ``taught``
    or ``inherited``.
    """

    instance_id: int
    name: str
    p: float
    accepted: bool
    source: str


@dataclass(frozen=True, slots=True)
class LabelDelta:
    """Names that changed since ``seq - 1`` of the same ``epoch``; all of them with ``full``.

    ``model_id`` is the encoder and ``label_set`` the set they are chosen from; ``map_epoch`` names
    the map whose instances are meant, a delta of another one is full.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.label_delta.v1"
    epoch: int
    seq: int
    full: bool
    frame_seq: int
    stamp_ns: int
    model_id: str
    label_set: str
    map_epoch: int
    labels: tuple[InstanceLabel, ...]
    removed: Annotated[Array, ArraySpec("<i4", (None,))]
