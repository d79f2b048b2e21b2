"""Cuts every keyframe into class-agnostic segments.

Reads   sceneq/frame/<robot>/<sensor>/v1, the newest ``inbox`` when it falls behind.
Writes  sceneq/mask/<scene>/v1: one label image for every frame read, under the frame's seq; a
        frame that comes again is answered again.
Rate    as frames come; latest wins.
Bad     a frame whose bytes do not decode is counted (``frames_undecodable``), logged and skipped;
        a frame the segmenter has no masks for gets an empty label image, is counted
        (``masks_missing``) and logged, so that mapping goes on with the next one.
"""

import logging
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import UInt16
from sceneq_core.frame import Frame
from sceneq_core.segmentation.segmenter import Segmenter
from sceneq_nodes._backends import build
from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes._images import frame_from_message
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.mask import Masks
from sceneq_schemas.topics import FRAME, MASK

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class SegmentationParams:
    """``segmenter``: kind and parameters of the backend; ``inbox``: frames kept when behind.

    ``robots``: whose frames are cut beside those of the graph's own robot.
    """

    segmenter: dict[str, Any] = field(default_factory=lambda: {"kind": "rgbd"})
    inbox: int = 4
    robots: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.inbox < 1:
            raise ValueError(f"inbox must be at least 1 frame, got {self.inbox}")


class Segmentation:
    """Publishes the segments of each frame."""

    Params: ClassVar[type] = SegmentationParams
    idle_s: ClassVar[float] = 1.0

    def __init__(self, params: SegmentationParams, context: Context) -> None:
        self._params = params
        self._context = context

    def open(self, bus: Bus) -> None:
        """Build the segmenter and listen to the sensor's frames."""
        self._bus = bus
        self._segmenter: Segmenter = build("segmenter", self._params.segmenter, ("segmenter",))
        context, depth = self._context, self._params.inbox
        for robot in (context.robot, *self._params.robots):
            bus.subscribe(FRAME, depth=depth, robot=robot, sensor=context.sensor)

    def step(self, received: Received | None) -> None:
        """Answer a frame with its masks."""
        if received is None:
            return
        message = received.message
        try:
            frame = frame_from_message(message)
        except DecodeError as error:
            self._bus.count("frames_undecodable")
            log.warning("frame %d on %s skipped: %s", message.seq, received.key, error)
            return
        masks = Masks(frame.seq, frame.stamp_ns, self._segments(frame))
        self._bus.publish(MASK, masks, scene=self._context.scene)

    def close(self) -> None:
        """Nothing to release."""

    def _segments(self, frame: Frame) -> UInt16:
        try:
            return self._segmenter.segment(frame)
        except ValueError as error:
            self._bus.count("masks_missing")
            log.warning("frame %d has no masks: %s", frame.seq, error)
            return np.zeros(frame.depth_m.shape, np.uint16)
