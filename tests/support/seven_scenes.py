"""Writes tiny folders in the 7-Scenes layout: a slanted wall, seen by a camera that moves."""

from pathlib import Path

import cv2
import numpy as np

K = np.array([[50.0, 0, 31.5], [0, 50.0, 23.5], [0, 0, 1]])
SIZE = (64, 48)


def write_folder(folder: Path, numbers: list[int], poses: bool = True) -> Path:
    """Write one frame per number; the camera goes 1 cm a number along x."""
    folder.mkdir(parents=True, exist_ok=True)
    np.savetxt(folder / "camera-intrinsics.txt", K)
    for number in numbers:
        stem = f"{folder}/frame-{number:06d}"
        cv2.imwrite(f"{stem}.color.png", color(number)[..., ::-1])
        cv2.imwrite(f"{stem}.depth.png", depth_mm(number))
        if poses:
            np.savetxt(f"{stem}.pose.txt", pose(number))
    return folder


def color(number: int) -> np.ndarray:
    """Return RGB with the number in the red channel."""
    rgb = np.full((SIZE[1], SIZE[0], 3), (0, 90, 200), np.uint8)
    rgb[..., 0] = number % 251
    return rgb


def depth_mm(number: int) -> np.ndarray:
    """Return a slanted wall with the two kinds of missing pixels in its corner."""
    depth = np.tile(np.linspace(1000, 1500, SIZE[0]), (SIZE[1], 1)).astype(np.uint16)
    depth[0, 0], depth[0, 1] = 0, 65535
    depth[5, 5] = 2000 + number
    return depth


def pose(number: int) -> np.ndarray:
    T_world_camera = np.eye(4)
    T_world_camera[0, 3] = 0.01 * number
    return T_world_camera
