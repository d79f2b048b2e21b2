"""Every thing in a picture from a network that segments what a point is on.

Asked at a grid of points, it gives three masks for each (part, thing, group) and how good it
thinks they are; what is unsure, unstable or double goes. A. Kirillov et al., Segment Anything,
ICCV 2023, doi 10.1109/ICCV51070.2023.00371, without its zoomed crops.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, UInt16
from sceneq_core.checks import need_at_least, need_within
from sceneq_core.segmentation.label_image import label_image
from sceneq_core.segmentation.letterbox import Letterbox
from sceneq_core.segmentation.mask_filter import mask_boxes, stability, suppress, without_specks
from sceneq_core.segmentation.point_grid import point_grid

Prompt = Callable[[Float32], tuple[Float32, Float32]]
"""Points (P, 2) in the network's pixels -> logits (P, M, h, w), predicted IoU (P, M)."""


@dataclass(frozen=True, slots=True)
class AutomaticParams:
    """``points_per_side`` of the grid, ``points_at_once`` for the network. Kept are masks with a
    predicted IoU of at least ``iou_min`` that keep ``stability_min`` of themselves when the
    threshold moves by ``stability_offset`` logits, and whose box overlaps a better one's by at
    most ``nms_iou``. Holes, islands and segments under ``least_px`` pixels are cleaned off.
    """

    points_per_side: int = 16
    points_at_once: int = 64
    iou_min: float = 0.88
    stability_min: float = 0.95
    stability_offset: float = 1.0
    nms_iou: float = 0.7
    least_px: int = 100

    def __post_init__(self) -> None:
        need_within(self, 1, 128, "points_per_side")
        need_at_least(self, 1, "points_at_once", "least_px")
        need_within(self, 0, 1, "iou_min", "stability_min", "nms_iou")
        need_at_least(self, 0, "stability_offset")


def automatic_labels(
    prompt: Prompt, box: Letterbox, size: tuple[int, int], params: AutomaticParams
) -> UInt16:
    """Return the labels uint16 (H, W) of the picture that lies in the network's input as ``box``.

    ``size`` (height, width) of the input in pixels.
    """
    logits, scores = _candidates(prompt, box, params)
    boxes = mask_boxes(logits > 0)
    masks = [
        without_specks(box.restored(logits[i], size) > 0, params.least_px)
        for i in suppress(boxes, scores, params.nms_iou)
    ]
    return label_image(masks, (box.height, box.width), params.least_px)


def _candidates(prompt: Prompt, box: Letterbox, params: AutomaticParams) -> tuple[Float32, Float32]:
    """Return logits (N, h, w) and scores (N,) of all masks that are sure and stable enough."""
    points = box.points(point_grid(params.points_per_side, box.height, box.width))
    found = []
    for start in range(0, len(points), params.points_at_once):
        logits, scores = prompt(points[start : start + params.points_at_once])
        sure = scores >= params.iou_min
        logits, scores = logits[sure], scores[sure]
        stable = stability(logits, params.stability_offset) >= params.stability_min
        found.append((logits[stable], scores[stable]))
    kept_logits, kept_scores = zip(*found, strict=True)
    return np.concatenate(kept_logits), np.concatenate(kept_scores)
