"""Writes the slanted wall of ``seven_scenes`` in the formats of other data sets."""

import json
import struct
import zlib
from pathlib import Path

import cv2
import numpy as np

from support.seven_scenes import SIZE, K, color, depth_mm, pose

REPLICA_SCALE = 6553.5
TUM_SCALE = 5000
MISSING = np.full((4, 4), -np.inf)
"""What ScanNet writes as the pose of a frame that its reconstruction lost."""


def write_replica(scene: Path, count: int) -> Path:
    """Write the NICE-SLAM layout; the camera file lies in the folder above the scene."""
    (scene / "results").mkdir(parents=True)
    camera = {"w": SIZE[0], "h": SIZE[1], "fx": 50.0, "fy": 50.0, "cx": 31.5, "cy": 23.5}
    document = {"camera": {**camera, "scale": REPLICA_SCALE}}
    (scene.parent / "cam_params.json").write_text(json.dumps(document))
    for number in range(count):
        cv2.imwrite(f"{scene}/results/frame{number:06d}.jpg", color(number)[..., ::-1])
        cv2.imwrite(f"{scene}/results/depth{number:06d}.png", units(number, REPLICA_SCALE))
    np.savetxt(scene / "traj.txt", [pose(number).ravel() for number in range(count)])
    return scene


def write_tum(sequence: Path, count: int) -> Path:
    """Write images 0.1 s apart; depth comes 10 ms later, poses every 20 ms."""
    for part in ("rgb", "depth"):
        (sequence / part).mkdir(parents=True)
    lists: dict[str, list[str]] = {"rgb": ["# color images"], "depth": ["# depth maps"]}
    for number in range(count):
        stamp = f"{100 + 0.1 * number:.6f}"
        later = f"{100 + 0.1 * number + 0.01:.6f}"
        cv2.imwrite(f"{sequence}/rgb/{stamp}.png", color(number)[..., ::-1])
        cv2.imwrite(f"{sequence}/depth/{later}.png", units(number, TUM_SCALE))
        lists["rgb"].append(f"{stamp} rgb/{stamp}.png")
        lists["depth"].append(f"{later} depth/{later}.png")
    for part, lines in lists.items():
        (sequence / f"{part}.txt").write_text("\n".join(lines) + "\n")
    stamps = 99.99 + 0.02 * np.arange(5 * count + 2)
    rows = [f"{s:.4f} {0.1 * (s - 100):.6f} 0 0 0 0 0 1" for s in stamps]
    header = "# timestamp tx ty tz qx qy qz qw"
    (sequence / "groundtruth.txt").write_text("\n".join([header, *rows]) + "\n")
    return sequence


def write_scannet_frames(scan: Path, count: int, lost: int | None = None) -> Path:
    """Write the frames as ScanNet's reader extracts them; colour has twice the size of depth."""
    for part in ("color", "depth", "pose", "intrinsic"):
        (scan / part).mkdir(parents=True)
    for number in range(count):
        (scan / "color" / f"{number}.jpg").write_bytes(large_jpeg(number))
        cv2.imwrite(f"{scan}/depth/{number}.png", depth_mm(number))
        np.savetxt(scan / "pose" / f"{number}.txt", MISSING if number == lost else pose(number))
    np.savetxt(scan / "intrinsic" / "intrinsic_color.txt", four_by_four(LARGE_K), fmt="%f")
    np.savetxt(scan / "intrinsic" / "intrinsic_depth.txt", four_by_four(K), fmt="%f")
    for part in ("color", "depth"):
        np.savetxt(scan / "intrinsic" / f"extrinsic_{part}.txt", np.eye(4), fmt="%f")
    return scan


LARGE_K = np.array([[100.0, 0, 63.5], [0, 100.0, 47.5], [0, 0, 1]])
"""The camera of an image twice as large: pixel centres are whole numbers."""


def sens_bytes(count: int, lost: int | None = None, version: int = 4, packed: int = 1) -> bytes:
    """Return a .sens file with ``count`` frames; that of ``lost`` has no pose."""
    name = b"StructureSensor"
    head = struct.pack("<IQ", version, len(name)) + name
    for matrix in (four_by_four(LARGE_K), np.eye(4), four_by_four(K), np.eye(4)):
        head += struct.pack("<16f", *matrix.ravel())
    sizes = (2 * SIZE[0], 2 * SIZE[1], *SIZE)
    head += struct.pack("<ii4IfQ", 2, packed, *sizes, 1000.0, count)
    return head + b"".join(sens_frame(n, n == lost, packed) for n in range(count))


def sens_frame(number: int, is_lost: bool, packed: int) -> bytes:
    raw = depth_mm(number).astype("<u2").tobytes()
    depth = zlib.compress(raw) if packed else raw
    rgb = large_jpeg(number)
    T_world_camera = MISSING if is_lost else pose(number)
    stamp_us = 33333 * number
    sizes = (len(rgb), len(depth))
    head = struct.pack("<16f4Q", *T_world_camera.ravel(), stamp_us, stamp_us, *sizes)
    return head + rgb + depth


def large_jpeg(number: int) -> bytes:
    large = cv2.resize(color(number), (2 * SIZE[0], 2 * SIZE[1]), interpolation=cv2.INTER_NEAREST)
    return cv2.imencode(".jpg", large[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 100])[1].tobytes()


def units(number: int, per_m: float) -> np.ndarray:
    """Return the wall's depth in other units, 0 where nothing was measured."""
    mm = depth_mm(number)
    mm[mm == 65535] = 0
    return np.rint(mm * (per_m / 1000)).astype(np.uint16)


def four_by_four(matrix: np.ndarray) -> np.ndarray:
    large = np.eye(4)
    large[:3, :3] = matrix
    return large
