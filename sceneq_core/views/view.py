"""A keyframe that shows an instance."""

from dataclasses import dataclass

from sceneq_core.arrays import Bool, Float32


@dataclass(frozen=True, slots=True)
class View:
    """One keyframe that shows an instance.

    ``box_xyxy`` float32 (4,) pixels of the keyframe; ``mask`` bool (h, w) covers the box at half
    resolution (``h = ceil(box height / 2)``); ``visible_px`` counts full-resolution pixels.
    """

    seq: int
    stamp_ns: int
    visible_px: int
    box_xyxy: Float32
    mask: Bool


@dataclass(frozen=True, slots=True)
class ViewSet:
    """The top-k views of one instance, best first; empty = gone, or nowhere to be seen."""

    instance_id: int
    views: tuple[View, ...]
