"""Masks from boxes, coefficients and prototypes, as networks of the YOLO family give them.

Each detection mixes a few prototype masks of the whole picture (YOLACT: D. Bolya et al., ICCV 2019,
doi 10.1109/ICCV.2019.00925); FastSAM is such a network for "anything" (X. Zhao et al., 2023, doi
10.48550/arXiv.2306.12156).
"""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Bool, Float32, UInt16
from sceneq_core.checks import need_at_least, need_within
from sceneq_core.segmentation.label_image import label_image
from sceneq_core.segmentation.letterbox import Letterbox
from sceneq_core.segmentation.mask_filter import suppress, without_specks


@dataclass(frozen=True, slots=True)
class DetectionParams:
    """Kept are detections of a ``score_min`` whose box overlaps a better one's by at most
    ``nms_iou``, the best ``most`` of them. Holes, islands and segments under ``least_px`` pixels
    are cleaned off. The defaults are FastSAM's.
    """

    score_min: float = 0.4
    nms_iou: float = 0.9
    most: int = 300
    least_px: int = 100

    def __post_init__(self) -> None:
        need_within(self, 0, 1, "score_min", "nms_iou")
        need_at_least(self, 1, "most", "least_px")


def detection_labels(
    detections: Float32,
    prototypes: Float32,
    box: Letterbox,
    size: tuple[int, int],
    params: DetectionParams,
) -> UInt16:
    """Return the labels uint16 (H, W) of the picture that lies in the network's input as ``box``.

    ``detections`` (4 + C + M, N): boxes as centre x, y, width, height in pixels of the input of
    ``size`` (height, width), scores of C classes, M coefficients; ``prototypes`` (M, h, w).
    """
    masks = len(prototypes)
    scores = detections[4:-masks].max(axis=0)
    sure = np.flatnonzero(scores >= params.score_min)
    boxes = _corners(detections[:4, sure].T)
    kept = suppress(boxes, scores[sure], params.nms_iou)[: params.most]
    mixed = np.tensordot(detections[-masks:, sure[kept]].T, prototypes, axes=1)
    found = [
        without_specks(_mask(one, corners, box, size), params.least_px)
        for one, corners in zip(mixed, boxes[kept], strict=True)
    ]
    return label_image(found, (box.height, box.width), params.least_px)


def _mask(logits: Float32, corners: Float32, box: Letterbox, size: tuple[int, int]) -> Bool:
    """Return where a mixture of prototypes is above 0, the sigmoid's middle, within its box."""
    x = (np.arange(box.width) + 0.5) * box.inner_width / box.width + box.left
    y = (np.arange(box.height) + 0.5) * box.inner_height / box.height + box.top
    inside_x, inside_y = (corners[0] <= x) & (x < corners[2]), (corners[1] <= y) & (y < corners[3])
    return np.asarray((box.restored(logits, size) > 0) & inside_y[:, None] & inside_x[None])


def _corners(boxes: Float32) -> Float32:
    """Return boxes (N, 4) of centre and size as left, top, right, bottom."""
    half = boxes[:, 2:] / 2
    return np.concatenate([boxes[:, :2] - half, boxes[:, :2] + half], axis=1)
