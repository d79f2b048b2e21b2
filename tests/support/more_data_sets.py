"""Writes the slanted wall of ``seven_scenes`` as other programs write their recordings."""

import json
import sqlite3
import struct
import zipfile
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np

from support.data_sets import large_jpeg, units
from support.seven_scenes import SIZE, K, color, pose

ARKIT = np.diag([1.0, -1.0, -1.0, 1.0])
T_BASE_CAMERA = np.array([[0.0, 0, 1, 0.1], [-1, 0, 0, 0], [0, -1, 0, 0.5], [0, 0, 0, 1]])
"""A camera that looks ahead on a robot, 10 cm before and 50 cm over its base."""


def write_redwood(folder: Path, count: int, names: Sequence[str] = ("color", "depth")) -> Path:
    """Write what Open3D's reconstruction system reads and its trajectory."""
    for name in names:
        (folder / name).mkdir(parents=True)
    for number in range(count):
        cv2.imwrite(f"{folder}/{names[0]}/{number:06d}.jpg", color(number)[..., ::-1])
        cv2.imwrite(f"{folder}/{names[1]}/{number:06d}.png", units(number, 1000))
    camera = {"width": SIZE[0], "height": SIZE[1], "intrinsic_matrix": K.T.ravel().tolist()}
    (folder / "camera_intrinsic.json").write_text(json.dumps(camera))
    write_log(folder / "trajectory.log", range(count))
    return folder


def write_log(path: Path, numbers: Sequence[int]) -> None:
    blocks = [f"{n} {n} {n + 1}\n" + text_of(pose(n)) for n in numbers]
    path.write_text("".join(blocks))


def text_of(matrix: np.ndarray) -> str:
    return "".join(" ".join(f"{value:.8f}" for value in row) + "\n" for row in matrix)


def write_r3d(
    path: Path, count: int, compress: Callable[[bytes], bytes], confidence: int = 2
) -> Path:
    """Write the app's zip; colour has twice the size of depth, the wall is seen upright."""
    two = np.array([[100.0, 0, 63.5], [0, 100.0, 47.5], [0, 0, 1]])
    metadata = {
        "w": 2 * SIZE[0],
        "h": 2 * SIZE[1],
        "dw": SIZE[0],
        "dh": SIZE[1],
        "fps": FPS,
        "K": two.T.ravel().tolist(),
        "poses": [arkit_pose(number) for number in range(count)],
        "initPose": [0, 0, 0, 1, 0, 0, 0],
    }
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("metadata", json.dumps(metadata))
        for number in range(count):
            depth_m = (units(number, 1000) / 1000).astype("<f4")
            depth_m[depth_m == 0] = np.nan
            held = np.full(SIZE[::-1], confidence, np.uint8)
            held[-1] = 0
            file.writestr(f"rgbd/{number}.jpg", large_jpeg(number))
            file.writestr(f"rgbd/{number}.depth", compress(depth_m.tobytes()))
            file.writestr(f"rgbd/{number}.conf", compress(held.tobytes()))
    return path


def arkit_pose(number: int) -> list[float]:
    """Return qx qy qz qw tx ty tz of the upright camera ``number`` cm to the right, y up."""
    return [0.0, 0.0, 0.0, 1.0, 0.01 * number, 0.0, 0.0]


NODE_S, FPS = 0.5, 60
RTABMAP_TABLES = """
CREATE TABLE Node (id INTEGER NOT NULL, map_id INTEGER NOT NULL, weight INTEGER, stamp FLOAT,
  pose BLOB, ground_truth_pose BLOB, velocity BLOB, label TEXT, gps BLOB, env_sensors BLOB,
  time_enter DATE, PRIMARY KEY (id));
CREATE TABLE Data (id INTEGER NOT NULL, image BLOB, depth BLOB, depth_confidence BLOB,
  calibration BLOB, scan BLOB, scan_info BLOB, user_data BLOB, time_enter DATE, PRIMARY KEY (id));
CREATE TABLE Admin (version TEXT, preview_image BLOB, opt_cloud BLOB, opt_ids BLOB, opt_poses BLOB,
  opt_last_localization BLOB, opt_map BLOB, time_enter DATE);
INSERT INTO Admin(version) VALUES('0.22.0');
"""
"""Those columns of RTAB-Map's schema that have to do with images and poses."""


def write_rtabmap(
    path: Path,
    count: int,
    depth: Callable[[int], bytes] | None = None,
    distortion: Sequence[float] = (0.0,) * 5,
    optimised: bool = True,
) -> Path:
    """Write nodes 1, 2, ... as RTAB-Map does; the last but one is not in the optimised graph."""
    file = sqlite3.connect(path)
    file.executescript(RTABMAP_TABLES)
    for number in range(1, count + 1):
        odometry = three_rows(base_pose(number + 100))
        row = (number, 0, 0, 1000.5 + NODE_S * number, odometry)
        file.execute("INSERT INTO Node(id, map_id, weight, stamp, pose) VALUES(?, ?, ?, ?, ?)", row)
        image = cv2.imencode(".jpg", color(number)[..., ::-1])[1].tobytes()
        data = (number, image, (depth or depth_png)(number), calibration_blob(distortion))
        file.execute("INSERT INTO Data(id, image, depth, calibration) VALUES(?, ?, ?, ?)", data)
    file.execute("INSERT INTO Node(id, map_id) VALUES(?, 0)", (count + 1,))  # without images
    if optimised:
        ids = np.array([n for n in range(1, count + 1) if n != count - 1], "<i4")
        poses = np.concatenate([np.frombuffer(three_rows(base_pose(n)), "<f4") for n in ids])
        blobs = (packed(ids[None], 4), packed(poses[None], 5))
        file.execute("UPDATE Admin SET opt_ids = ?, opt_poses = ?", blobs)
    file.commit()
    file.close()
    return path


def base_pose(number: int) -> np.ndarray:
    """Return where the robot stands when its camera is where ``pose`` says."""
    return pose(number) @ np.linalg.inv(T_BASE_CAMERA)


def three_rows(matrix: np.ndarray) -> bytes:
    return matrix[:3].astype("<f4").tobytes()


def packed(matrix: np.ndarray, kind: int) -> bytes:
    return zlib.compress(matrix.tobytes()) + struct.pack("<3i", *matrix.shape, kind)


def calibration_blob(distortion: Sequence[float]) -> bytes:
    head = struct.pack("<11i", 0, 22, 1, 0, *SIZE, 9, len(distortion), 9, 12, 12)
    projection = np.hstack([K, np.zeros((3, 1))])
    numbers = np.concatenate([K.ravel(), distortion, np.eye(3).ravel(), projection.ravel()])
    return head + numbers.astype("<f8").tobytes() + three_rows(T_BASE_CAMERA)


def depth_png(number: int) -> bytes:
    return cv2.imencode(".png", units(number, 1000))[1].tobytes()


def depth_float_png(number: int) -> bytes:
    """Return metres as RTAB-Map stores CV_32FC1: the bytes of a float as one pixel."""
    depth_m = (units(number, 1000) / 1000).astype("<f4")
    return cv2.imencode(".png", depth_m.view(np.uint8).reshape(*depth_m.shape, 4))[1].tobytes()


def depth_rvl(number: int) -> bytes:
    return b"DEPTHRVL" + struct.pack("<2I", *SIZE) + rvl(units(number, 1000))


def rvl(depth: np.ndarray) -> bytes:
    """Compress as the paper does, number by number."""
    nibbles: list[int] = []

    def put(value: int) -> None:
        while True:
            value, low = value >> 3, value & 7
            nibbles.append(low | (8 if value else 0))
            if not value:
                return

    pixels, at, last = depth.ravel().tolist(), 0, 0
    while at < len(pixels):
        for is_held in (False, True):
            run = at
            while run < len(pixels) and (pixels[run] != 0) == is_held:
                run += 1
            put(run - at)
            for value in pixels[at:run] if is_held else ():
                step, last = value - last, value
                put(2 * step if step >= 0 else -2 * step - 1)
            at = run
    nibbles += [0] * (-len(nibbles) % 8)
    words = [
        int("".join(f"{n:x}" for n in nibbles[i : i + 8]), 16) for i in range(0, len(nibbles), 8)
    ]
    return struct.pack(f"<{len(words)}I", *words)
