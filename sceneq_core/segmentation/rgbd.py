"""Segments from colour and depth, with nothing learned."""

from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Int32, UInt16
from sceneq_core.checks import need_between, need_positive
from sceneq_core.frame import Frame
from sceneq_core.segmentation.flats import flats_of
from sceneq_core.segmentation.solids import Limits, Solids, solids_of
from sceneq_core.segmentation.surface import surface_of
from sceneq_core.segmentation.working_image import enlarged, reduced

_BLUR_PX = 0.8
_SLIVER = np.ones((5, 5), np.uint8)


@dataclass(frozen=True, slots=True)
class RgbdParams:
    """What the segmenter takes for noise and for a thing.

    Attributes:
        width_px: frames are reduced to at most this width; finer detail is mostly sensor noise.
        depth_noise: error of inverse depth in 1/m, the same at every distance for a triangulating
            sensor; 0.0014 is the first Kinect's (K. Khoshelham, S. Oude Elberink 2012,
            doi:10.3390/s120201437: 1.4 mm at 1 m, growing with the square of depth).
        min_fold_deg: two surfaces that meet at a sharper concave angle are two things.
        min_height_m: what stands less over its plane is seen by colour only: depth frays its edge.
        colour_scale: colour difference x pixels; larger means fewer flat things.
        contrast: CIELAB difference at which a patch on a plane is not the plane itself.
        min_share: a thing covers at least this share of the image.
        min_plane_share: a surface that covers this share may carry things.
    """

    width_px: int = 320
    depth_noise: float = 0.0014
    min_fold_deg: float = 25.0
    min_height_m: float = 0.03
    colour_scale: float = 40.0
    contrast: float = 12.0
    min_share: float = 0.0008
    min_plane_share: float = 0.02

    def __post_init__(self) -> None:
        need_positive(self, "width_px", "depth_noise", "min_height_m")
        need_positive(self, "colour_scale", "contrast")
        need_between(self, 0, 180, "min_fold_deg")
        need_between(self, 0, 1, "min_share", "min_plane_share")


class RgbdSegmenter:
    """Solids by depth steps and concave creases; flat things by colour where there is no shape."""

    Params: ClassVar[type] = RgbdParams

    def __init__(self, params: RgbdParams) -> None:
        self._params = params

    def segment(self, frame: Frame) -> UInt16:
        """Return a label image uint16 (H, W), 0 = no segment; walls and floors are segments."""
        params = self._params
        image = reduced(frame, params.width_px)
        min_pixels = max(12, round(params.min_share * image.closeness.size))
        surface = surface_of(image, params.depth_noise, params.min_fold_deg)
        solids = solids_of(surface, self._limits(min_pixels, image.closeness.size))
        flats = flats_of(
            np.asarray(cv2.GaussianBlur(image.colour, (0, 0), _BLUR_PX), np.float32),
            planes=solids.planes,
            blank=_blank(solids),
            scale=params.colour_scale,
            contrast=params.contrast,
            min_pixels=min_pixels,
        )
        labels = np.where(flats > 0, flats + solids.labels.max(), solids.labels)
        numbers = _numbered(_completed(labels))
        return np.ascontiguousarray(enlarged(numbers, image.step, frame.depth_m.shape))

    def _limits(self, min_pixels: int, pixels: int) -> Limits:
        params = self._params
        return Limits(
            noise=params.depth_noise,
            height_m=params.min_height_m,
            pixels=min_pixels,
            plane_pixels=round(params.min_plane_share * pixels),
        )


def _blank(solids: Solids) -> Bool:
    """Return where no solid is; slivers along their outlines are left to ``_completed``."""
    empty = (solids.labels == 0).astype(np.uint8)
    return np.asarray(cv2.morphologyEx(empty, cv2.MORPH_OPEN, _SLIVER) > 0)


def _completed(labels: Int32) -> Int32:
    """Return ``labels`` with every unlabelled pixel near a segment given to the nearest one."""
    if not labels.any():
        return labels
    empty = (labels == 0).astype(np.uint8)
    distance, nearest = cv2.distanceTransformWithLabels(
        empty, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    label_of = np.zeros(nearest.max() + 1, np.int32)
    label_of[nearest[empty == 0]] = labels[empty == 0]
    return np.where(distance <= _SLIVER.shape[0], label_of[nearest], 0).astype(np.int32)


def _numbered(labels: Int32) -> UInt16:
    """Return ``labels`` renumbered 1, 2, ... in the order of their old numbers; 0 stays."""
    present = np.bincount(labels.reshape(-1)) > 0
    present[0] = False
    numbers: UInt16 = (np.cumsum(present) * present).astype(np.uint16)[labels]
    return numbers
