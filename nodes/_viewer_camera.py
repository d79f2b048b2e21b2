"""What the camera sees, in a Rerun recording: pose, picture, segments and the way it went."""

from collections import deque
from typing import Any

import numpy as np

from sceneq_core.arrays import Array
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_core.picture.colours import instance_colours
from sceneq_core.views.jpeg import jpeg_from_rgb
from sceneq_nodes._images import array_from_image
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.frame import Frame, ImageData
from sceneq_schemas.mask import Masks

CAMERA, RGB, MASKS, PATH = "world/camera", "world/camera/rgb", "world/camera/masks", "world/path"
FRUSTUM_M = 0.5
MASK_OPACITY = 0.45
COLOURED_SEGMENTS = 1024
"""Segments with higher numbers, which no picture has, get colours of the viewer's own."""
PATH_POSES = 2000
PATH_RGB = (255, 160, 0)
PATH_RADIUS_M = 0.012


class CameraLog:
    """Logs keyframes and their segments into one recording."""

    def __init__(self, recording: Any) -> None:
        import rerun as rr

        self._recording = recording
        self._shown: dict[str, tuple[Any, ...]] = {}
        self._path: deque[Any] = deque(maxlen=PATH_POSES)
        ids = np.arange(1, COLOURED_SEGMENTS, dtype=np.int32)
        colours = instance_colours(ids, np.full((len(ids), 3), 255, np.uint8))
        context = [rr.AnnotationInfo(0, color=(0, 0, 0, 0))]
        for number, rgb in zip(ids.tolist(), colours.tolist(), strict=True):
            context.append(rr.AnnotationInfo(number, color=tuple(rgb)))
        recording.log(CAMERA, rr.AnnotationContext(context), static=True)

    def frame(self, frame: Frame) -> None:
        """Log the picture and where it was taken.

        Raises:
            DecodeError: the picture, the pose or the intrinsics are none.
        """
        import rerun as rr

        T_world_camera, jpeg = frame.T_world_camera, _jpeg(frame.rgb)
        height, width = frame.rgb.shape[:2]
        if defect := rigid_defect(T_world_camera):
            raise DecodeError(f"Frame.T_world_camera: {defect}")
        if not np.isfinite(frame.K).all():
            raise DecodeError(f"Frame.K: not finite: {frame.K.tolist()}")
        self._path.append(T_world_camera[:3, 3])
        self._log(
            CAMERA,
            rr.Transform3D(translation=T_world_camera[:3, 3], mat3x3=T_world_camera[:3, :3]),
            rr.Pinhole(
                image_from_camera=frame.K,
                resolution=(width, height),
                camera_xyz=rr.ViewCoordinates.RDF,
                image_plane_distance=FRUSTUM_M,
                color=PATH_RGB,
            ),
        )
        self._log(RGB, rr.EncodedImage(contents=jpeg, media_type="image/jpeg"))
        path = rr.LineStrips3D([list(self._path)], colors=[PATH_RGB], radii=PATH_RADIUS_M)
        self._log(PATH, path)

    def masks(self, masks: Masks) -> None:
        """Log the segments as a coloured layer over the picture."""
        import rerun as rr

        labels: Array = masks.label_image
        if labels.max(initial=0) < 256:
            labels = labels.astype(np.uint8)  # half the size
        layer = rr.SegmentationImage(labels, opacity=MASK_OPACITY)
        self._log(MASKS, layer)

    def repeat(self) -> None:
        """Log the last keyframe and its segments again."""
        for path, shown in self._shown.items():
            self._recording.log(path, *shown)

    def _log(self, path: str, *shown: Any) -> None:
        self._shown[path] = shown
        self._recording.log(path, *shown)


def _jpeg(image: ImageData) -> bytes:
    """Return the picture as JPEG bytes, as they came where they were.

    Raises:
        DecodeError: not a colour picture of 8 bits.
    """
    if image.dtype != "|u1" or len(image.shape) != 3:
        raise DecodeError(f"Frame.rgb: got {image.dtype!r:.20} of shape {image.shape!r:.60}")
    if image.codec == "jpeg":
        return image.data
    return jpeg_from_rgb(array_from_image(image))
