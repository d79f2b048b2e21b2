"""A keyframe small enough to be kept for good, and rich enough to be recognised."""

from dataclasses import dataclass, field, replace

import cv2
import numpy as np

from sceneq_core.arrays import Float64, UInt8, UInt16
from sceneq_core.checks import need_at_least
from sceneq_core.frame import Frame, depth_to_mm
from sceneq_core.ingest.depth_view import DepthView, DepthViewParams, depth_view, thin_depth
from sceneq_core.ingest.shading import shading
from sceneq_core.ingest.source import Camera

QUALITY = 90


@dataclass(frozen=True, slots=True)
class PlaceParams:
    """``columns``: width of the picture kept, pixels; ``depth``: how its depth is thinned."""

    columns: int = 480
    depth: DepthViewParams = field(default_factory=DepthViewParams)

    def __post_init__(self) -> None:
        need_at_least(self, 64, "columns")


@dataclass(frozen=True, slots=True)
class Place:
    """What a camera saw at ``T_world_camera`` (4, 4), about 80 KB.

    Attributes:
        seq: number of the keyframe in its scene.
        T_world_camera: float64 (4, 4), metres.
        jpeg: grey picture.
        K: float64 (3, 3) of that picture.
        depth_mm: uint16 (h, w) thinned depth, 0 = none.
        K_depth: float64 (3, 3) of the depth.
    """

    seq: int
    T_world_camera: Float64
    jpeg: bytes
    K: Float64
    depth_mm: UInt16
    K_depth: Float64

    def at(self, T_world_camera: Float64) -> "Place":
        """Return the place with the camera at another pose."""
        return replace(self, T_world_camera=T_world_camera)

    def grey(self) -> UInt8:
        """Return the picture, uint8 (H, W); raise ``ValueError`` when it is none."""
        grey = cv2.imdecode(np.frombuffer(self.jpeg, np.uint8), cv2.IMREAD_GRAYSCALE)
        if grey is None:
            raise ValueError(f"the picture of place {self.seq} is no JPEG")
        return np.asarray(grey, np.uint8)

    def view(self, params: DepthViewParams) -> DepthView:
        """Return the surface with its brightness, to be aligned with another view."""
        grey = self.grey()
        rgb = np.asarray(cv2.cvtColor(grey, cv2.COLOR_GRAY2RGB), np.uint8)
        camera = Camera(self.K, (grey.shape[1], grey.shape[0]))
        view = depth_view(self.depth_mm, self.K_depth, params)
        return view.shaded(shading(rgb, camera, np.eye(4)))


def place_of(frame: Frame, params: PlaceParams) -> Place:
    """Return what is kept of a keyframe."""
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY)
    grey, K = _scaled(np.asarray(grey, np.uint8), frame.K, params.columns)
    jpeg: UInt8 = cv2.imencode(".jpg", grey, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
    thin_mm, K_thin = thin_depth(depth_to_mm(frame.depth_m), frame.K, params.depth)
    return Place(frame.seq, frame.T_world_camera.copy(), jpeg.tobytes(), K, thin_mm.copy(), K_thin)


def _scaled(grey: UInt8, K: Float64, columns: int) -> tuple[UInt8, Float64]:
    """Return the picture at most ``columns`` wide and its intrinsics."""
    height, width = grey.shape
    if width <= columns:
        return grey, K.copy()
    size = (columns, max(1, round(height * columns / width)))
    small = cv2.resize(grey, size, interpolation=cv2.INTER_AREA)
    scale = np.array([size[0] / width, size[1] / height])
    K_small = K.copy()
    K_small[:2] *= scale[:, None]
    K_small[:2, 2] += 0.5 * (scale - 1.0)  # the middle of a pixel is a whole number
    return np.asarray(small, np.uint8), K_small
