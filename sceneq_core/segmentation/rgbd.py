"""Segments from colour and depth, with nothing learned."""

from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Int32, UInt16
from sceneq_core.frame import Frame
from sceneq_core.segmentation.flats import flats_of
from sceneq_core.segmentation.solids import Solids, solids_of
from sceneq_core.segmentation.surface import surface_of
from sceneq_core.segmentation.working_image import enlarged, reduced


@dataclass(frozen=True, slots=True)
class RgbdParams:
    """What the segmenter takes for noise and for a thing.

    Attributes:
        width_px: frames are reduced to at most this width; finer detail is mostly sensor noise.
        depth_noise: error of inverse depth in 1/m, the same at every distance for a triangulating
            sensor; 0.0014 is the first Kinect's (K. Khoshelham, S. Oude Elberink 2012,
            doi:10.3390/s120201437: 1.4 mm at 1 m, growing with the square of depth).
        min_fold_deg: two surfaces that meet at a sharper concave angle are two things.
        colour_scale: colour difference x pixels; larger means fewer flat things.
        contrast: CIELAB difference at which a patch on a plane is not the plane itself.
        min_share: a thing covers at least this share of the image.
        min_plane_share: a surface that covers this share may carry things.
    """

    width_px: int = 320
    depth_noise: float = 0.0014
    min_fold_deg: float = 25.0
    colour_scale: float = 40.0
    contrast: float = 12.0
    min_share: float = 0.0008
    min_plane_share: float = 0.02

    def __post_init__(self) -> None:
        for name in ("width_px", "depth_noise", "colour_scale", "contrast"):
            if getattr(self, name) <= 0:
                raise ValueError(f"{name} must be positive, got {getattr(self, name)}")
        if not 0 < self.min_fold_deg < 180:
            raise ValueError(f"min_fold_deg must be in (0, 180), got {self.min_fold_deg}")
        for name in ("min_share", "min_plane_share"):
            if not 0 < getattr(self, name) < 1:
                raise ValueError(f"{name} must be in (0, 1), got {getattr(self, name)}")


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
        solids = solids_of(
            surface,
            params.depth_noise,
            min_pixels=min_pixels,
            min_plane_pixels=round(params.min_plane_share * image.closeness.size),
        )
        flats = flats_of(
            cv2.GaussianBlur(image.colour, (0, 0), 0.8),
            planes=solids.planes,
            blank=_blank(solids),
            scale=params.colour_scale,
            contrast=params.contrast,
            min_pixels=min_pixels,
        )
        labels = np.where(flats > 0, flats + solids.labels.max(), solids.labels)
        return np.ascontiguousarray(enlarged(_numbered(labels), frame.depth_m.shape))


def _blank(solids: Solids) -> Bool:
    return np.asarray(solids.labels == 0)


def _numbered(labels: Int32) -> UInt16:
    """Return ``labels`` renumbered 1, 2, ... in the order of their old numbers; 0 stays."""
    present = np.unique(labels)
    number = np.searchsorted(present[present > 0], labels) + 1
    return np.where(labels > 0, number, 0).astype(np.uint16)
