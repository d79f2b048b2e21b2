"""Places as messages, and messages as places."""

import numpy as np

from sceneq_core.ingest.transforms import rigid_defect
from sceneq_core.places.place import Place
from sceneq_core.views.jpeg import jpeg_size
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.place import Place as PlaceMessage

MAX_SIDE_PX = 4096


def place_message(place: Place) -> PlaceMessage:
    """Return a place as it is told."""
    return PlaceMessage(
        place.seq, place.T_world_camera, place.jpeg, place.K, place.depth_mm, place.K_depth
    )


def place_from_message(message: PlaceMessage) -> Place:
    """Return the place in a message.

    Raises:
        DecodeError: no rigid pose, no camera, or a picture that is none or too large.
    """
    size = jpeg_size(message.jpeg)
    if size is None or not 0 < min(size) <= max(size) <= MAX_SIDE_PX:
        raise DecodeError(f"place {message.seq}: a picture of {size}")
    if not 0 < min(message.depth_mm.shape) <= max(message.depth_mm.shape) <= MAX_SIDE_PX:
        raise DecodeError(f"place {message.seq}: depth of {message.depth_mm.shape}")
    if defect := rigid_defect(message.T_world_camera):
        raise DecodeError(f"place {message.seq}: T_world_camera: {defect}")
    for K in (message.K, message.K_depth):
        if not (np.isfinite(K).all() and (np.diag(K)[:2] > 0).all()):
            raise DecodeError(f"place {message.seq}: K {K.tolist()}")
    return Place(
        message.seq,
        message.T_world_camera,
        message.jpeg,
        message.K,
        message.depth_mm,
        message.K_depth,
    )
