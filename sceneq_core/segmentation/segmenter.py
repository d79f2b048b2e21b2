"""The seam between the map and whatever cuts images into segments."""

from typing import Protocol

from sceneq_core.arrays import UInt16
from sceneq_core.frame import Frame


class Segmenter(Protocol):
    """Cuts a frame into class-agnostic segments."""

    def segment(self, frame: Frame) -> UInt16:
        """Return a label image uint16 (H, W) in the frame's colour camera, 0 = no segment."""
