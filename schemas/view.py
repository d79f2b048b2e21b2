"""What views writes: per instance the keyframes that show it best."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class View:
    """One keyframe that shows an instance.

    ``box_xyxy`` in pixels of the keyframe; ``mask_bits`` are the packed rows of a boolean mask of
    ``mask_shape`` (h, w) that covers the box; ``visible_px`` counts full-resolution pixels.
    """

    seq: int
    stamp_ns: int
    visible_px: int
    box_xyxy: Annotated[Array, ArraySpec("<f4", (4,))]
    mask_shape: tuple[int, ...]
    mask_bits: bytes


@dataclass(frozen=True, slots=True)
class ViewSet:
    """The top-k views of one instance, most visible first; empty = the instance is gone."""

    instance_id: int
    views: tuple[View, ...]


@dataclass(frozen=True, slots=True)
class ViewDelta:
    """View sets that changed since ``seq - 1`` of the same ``epoch``; all of them with ``full``.

    ``map_epoch`` and ``map_seq`` name the map revision the visibility was computed against and
    ``frame_seq`` the newest keyframe seen; a delta of another map epoch is full.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.view.v1"
    epoch: int
    seq: int
    full: bool
    frame_seq: int
    stamp_ns: int
    map_epoch: int
    map_seq: int
    view_sets: tuple[ViewSet, ...]
