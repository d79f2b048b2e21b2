"""A walk through the papered room as a recording, in a frame of reference of its own."""

from pathlib import Path

import cv2
import numpy as np

from support.papered_room import PaperedRoom


def write_walk(
    folder: Path, room: PaperedRoom, turns_deg, T_odom_world=None, first: int = 0
) -> Path:
    """Write a frame for every turn, the first one number ``first``, with masks and poses.

    Returns ``folder``.
    """
    T_odom_world = np.eye(4) if T_odom_world is None else T_odom_world
    folder.mkdir(parents=True, exist_ok=True)
    np.savetxt(folder / "camera-intrinsics.txt", room.K)
    np.savetxt(folder / "stamps.txt", np.arange(first, first + len(turns_deg), dtype=float))
    for i, turn in enumerate(turns_deg, first):
        frame, labels = room.seen(i, turn, *step_aside(turn))
        stem = str(folder / f"frame-{i:06d}")
        cv2.imwrite(f"{stem}.color.png", frame.rgb[..., ::-1])
        cv2.imwrite(f"{stem}.depth.png", np.rint(frame.depth_m * 1000).astype(np.uint16))
        cv2.imwrite(f"{stem}.mask.png", labels)
        np.savetxt(f"{stem}.pose.txt", T_odom_world @ frame.T_world_camera)
    return folder


def step_aside(turn_deg: float) -> tuple[float, float]:
    """Return where on the floor the camera is that looks this way, metres."""
    return 0.3 * float(np.cos(np.radians(3 * turn_deg))), 0.3 * float(np.sin(np.radians(turn_deg)))
