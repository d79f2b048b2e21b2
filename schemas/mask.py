"""What segmentation writes: the class-agnostic 2D segments of one keyframe."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class Masks:
    """Segments of keyframe ``seq`` as one label image: 0 = no segment, ids mean nothing outside."""

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.mask.v1"
    seq: int
    stamp_ns: int
    label_image: Annotated[Array, ArraySpec("<u2", (None, None))]
