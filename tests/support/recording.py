"""Writes the ray-cast room as a folder in the 7-Scenes layout."""

from pathlib import Path

import cv2
import numpy as np

from support.room import Room


def write_recording(folder: Path, frames: int = 12, room: Room | None = None) -> Path:
    """Write ``frames`` views with exact masks and poses; return ``folder``."""
    room = room or Room()
    folder.mkdir(parents=True, exist_ok=True)
    np.savetxt(folder / "camera-intrinsics.txt", room.K)
    for i in range(frames):
        rgb, depth_mm, instance, T_world_camera = room.frame(i, frames)
        stem = str(folder / f"frame-{i:06d}")
        cv2.imwrite(f"{stem}.color.png", rgb[..., ::-1])
        cv2.imwrite(f"{stem}.depth.png", depth_mm)
        cv2.imwrite(f"{stem}.mask.png", instance)
        np.savetxt(f"{stem}.pose.txt", T_world_camera)
    return folder
