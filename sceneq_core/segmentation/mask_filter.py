"""Which of many overlapping masks are kept, and what is cleaned off them."""

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Int64


def stability(logits: Float32, offset: float) -> Float32:
    """Return how little each mask changes with its threshold, (N,): 0 to 1.

    IoU of {logit > offset} and {logit > -offset}, one within the other; 0 for an empty mask.
    ``logits`` (N, H, W). A. Kirillov et al., Segment Anything, ICCV 2023, doi
    10.1109/ICCV51070.2023.00371.
    """
    inner = np.count_nonzero(logits > offset, axis=(1, 2))
    outer = np.count_nonzero(logits > -offset, axis=(1, 2))
    return np.asarray(inner / np.maximum(outer, 1), np.float32)


def mask_boxes(masks: Bool) -> Float32:
    """Return the boxes (N, 4) around ``masks`` (N, H, W): left, top, right, bottom, the last two
    one past the mask; zeros for an empty one.
    """
    boxes = np.zeros((len(masks), 4), np.float32)
    for box, mask in zip(boxes, masks, strict=True):
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        if len(rows):
            box[:] = columns[0], rows[0], columns[-1] + 1, rows[-1] + 1
    return boxes


def suppress(boxes_xyxy: Float32, scores: Float32, most_iou: float) -> Int64:
    """Return the indices of the boxes (N, 4) to keep, best first: greedy non-maximum suppression.

    A box goes when it overlaps a kept one by more than ``most_iou``. Of equal scores the first
    counts as the better one.
    """
    left = np.argsort(-scores, kind="stable")
    kept = []
    while len(left):
        best, left = left[0], left[1:]
        kept.append(best)
        left = left[box_iou(boxes_xyxy[best], boxes_xyxy[left]) <= most_iou]
    return np.array(kept, np.int64)


def box_iou(box_xyxy: Float32, boxes_xyxy: Float32) -> Float32:
    """Return the IoU (N,) of one box (4,) with others (N, 4); 0 where both are empty."""
    low = np.maximum(box_xyxy[:2], boxes_xyxy[:, :2])
    high = np.minimum(box_xyxy[2:], boxes_xyxy[:, 2:])
    common = np.clip(high - low, 0, None).prod(axis=1)
    sizes = np.clip(boxes_xyxy[:, 2:] - boxes_xyxy[:, :2], 0, None).prod(axis=1)
    whole = np.clip(box_xyxy[2:] - box_xyxy[:2], 0, None).prod() + sizes - common
    return np.asarray(common / np.maximum(whole, 1e-9), np.float32)


def without_specks(mask: Bool, least_px: int) -> Bool:
    """Return ``mask`` (H, W) without holes and islands smaller than ``least_px`` pixels.

    Its largest island stays, however small.
    """
    filled = ~_without_small(~mask, least_px, keep_largest=False)
    return _without_small(filled, least_px, keep_largest=True)


def _without_small(mask: Bool, least_px: int, *, keep_largest: bool) -> Bool:
    count, pieces, stats, _ = cv2.connectedComponentsWithStats(
        mask.astype(np.uint8), None, None, None, 8
    )
    area = stats[:, cv2.CC_STAT_AREA].copy()
    keeps = area >= least_px
    if keep_largest and count > 1:
        keeps[1 + int(area[1:].argmax())] = True
    keeps[0] = False
    return np.asarray(keeps[pieces], np.bool_)
