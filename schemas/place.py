"""What mapping tells of the places of its map, for whoever has to find out where in it it is."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class Place:
    """A keyframe at a place: its pose, a small grey picture and thinned depth.

    ``jpeg`` has the intrinsics ``K``; ``depth_mm`` uint16 (h, w) millimetres, 0 = none, has
    ``K_depth``.
    """

    seq: int
    T_world_camera: Annotated[Array, ArraySpec("<f8", (4, 4))]
    jpeg: bytes
    K: Annotated[Array, ArraySpec("<f8", (3, 3))]
    depth_mm: Annotated[Array, ArraySpec("<u2", (None, None))]
    K_depth: Annotated[Array, ArraySpec("<f8", (3, 3))]


@dataclass(frozen=True, slots=True)
class PlaceSet:
    """All places of the map ``epoch``; ``seq`` grows whenever one of them changes."""

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.places.v1"
    epoch: int
    seq: int
    places: tuple[Place, ...]
