"""The ray-cast room in the files of many programs, by the writers that show a slanted wall else."""

import json
import sys
import zipfile
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType

import cv2
import numpy as np
import pytest

from sceneq_core.ingest.quaternion import quaternion_of
from sceneq_nodes._folder_source import KINECT_COLOR, KINECT_DEPTH, KINECT_SIZE
from sceneq_nodes.datasets.azure_calibration import read_calibration
from sceneq_tools.import_command import run as run_import

from support import azure_files, bags, data_sets, fake_cameras, more_data_sets, realsense_recording
from support.recording import write_recording
from support.room import Room

FRAMES = 6
RED_BALL_M = np.array([-0.35, 0.95, 0.84])


class Slow(Room):
    """The room seen by a camera that odometry can follow: less than 7 degrees a frame."""

    def pose(self, i: int, n: int) -> np.ndarray:
        return super().pose(i, 10)


ROOM = Slow(size=(160, 120), focal_px=130.0)
WORLD = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
"""ARKit's y up becomes z up."""
SHOWING = (azure_files, bags, data_sets, fake_cameras, more_data_sets, realsense_recording)


@cache
def shot(number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return colour, millimetres and pose of a frame of the room."""
    rgb, depth_mm, _, T_world_camera = ROOM.frame(number, FRAMES)
    return rgb, depth_mm, T_world_camera


def show_room(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the writers of the tests' wall, and the fake cameras, show the room instead."""
    zipped = ModuleType("liblzfse")
    zipped.compress, zipped.decompress = zlib.compress, zlib.decompress
    monkeypatch.setitem(sys.modules, "liblzfse", zipped)
    large = np.asarray(ROOM.K) * np.array([[2.0], [2.0], [1.0]])
    large[:2, 2] += 0.5
    shown = {
        "SIZE": ROOM.size,
        "K": np.asarray(ROOM.K),
        "LARGE_K": large,
        "color": lambda number: shot(number)[0],
        "depth_mm": lambda number: shot(number)[1].copy(),
        "pose": lambda number: shot(number)[2],
        "arkit_pose": arkit_pose,
        "NODE_S": 1 / 30,
        "FPS": 30,
        "STEP_NS": 33_333_333,
    }
    for module in SHOWING:
        for name, value in shown.items():
            if hasattr(module, name):
                monkeypatch.setattr(module, name, value)


def arkit_pose(number: int) -> list[float]:
    T_arkit = np.linalg.inv(WORLD) @ shot(number)[2] @ more_data_sets.ARKIT
    return [*quaternion_of(T_arkit[:3, :3]), *T_arkit[:3, 3]]


def folder(path: Path) -> Path:
    return write_recording(path, FRAMES, ROOM)


def seven_scenes(path: Path) -> Path:
    """Write a sequence as it is published: 640x480 of a Kinect, and no file about its cameras."""
    path.mkdir()
    small = np.diag([0.5, 0.5, 1.0])
    for number in range(FRAMES):
        stem, T_world_camera = f"{path}/frame-{number:06d}", shot(number)[2]
        rgb, _ = seen(small @ KINECT_COLOR, (320, 240), T_world_camera)
        _, depth_mm = seen(small @ KINECT_DEPTH, (320, 240), T_world_camera)
        depth_mm[depth_mm == 0] = 65535
        for part, image in (("color", rgb[..., ::-1]), ("depth", depth_mm)):
            large = cv2.resize(image, KINECT_SIZE, interpolation=cv2.INTER_NEAREST)
            cv2.imwrite(f"{stem}.{part}.png", large)
        np.savetxt(f"{stem}.pose.txt", T_world_camera)
    return path


def converted(path: Path) -> Path:
    run_import(folder(path / "folder"), path / "room.mcap", quiet=True)
    return path / "room.mcap"


def tum(path: Path) -> Path:
    """Write images without loss and poses at their stamps."""
    for part in ("rgb", "depth"):
        (path / part).mkdir(parents=True)
    lines: dict[str, list[str]] = {"rgb": [], "depth": [], "groundtruth": []}
    for number in range(FRAMES):
        rgb, depth_mm, T_world_camera = shot(number)
        stamp = f"{1e9 + number / 30:.6f}"
        cv2.imwrite(f"{path}/rgb/{stamp}.png", rgb[..., ::-1])
        cv2.imwrite(f"{path}/depth/{stamp}.png", (depth_mm * 5.0).astype(np.uint16))
        for part in ("rgb", "depth"):
            lines[part].append(f"{stamp} {part}/{stamp}.png")
        turned = quaternion_of(T_world_camera[:3, :3])
        pose = " ".join(repr(float(v)) for v in (*T_world_camera[:3, 3], *turned))
        lines["groundtruth"].append(f"{stamp} {pose}")
    for name, texts in lines.items():
        (path / f"{name}.txt").write_text("\n".join(texts) + "\n")
    np.savetxt(path / "camera-intrinsics.txt", ROOM.K)
    return path


def replica(path: Path) -> Path:
    written = data_sets.write_replica(path / "room", FRAMES)
    (fx, _, cx), (_, fy, cy), _ = np.asarray(ROOM.K).tolist()
    camera = {"w": ROOM.size[0], "h": ROOM.size[1], "fx": fx, "fy": fy, "cx": cx, "cy": cy}
    document = {"camera": {**camera, "scale": data_sets.REPLICA_SCALE}}
    (path / "cam_params.json").write_text(json.dumps(document))
    return written


def r3d(path: Path) -> Path:
    written = more_data_sets.write_r3d(path.with_suffix(".r3d"), FRAMES, zlib.compress)
    with zipfile.ZipFile(written) as old:
        parts = {name: old.read(name) for name in old.namelist()}
    metadata = json.loads(parts["metadata"])
    metadata["K"] = data_sets.LARGE_K.T.ravel().tolist()
    parts["metadata"] = json.dumps(metadata).encode()
    with zipfile.ZipFile(written, "w") as new:
        for name, data in parts.items():
            new.writestr(name, data)
    return written


def sens(path: Path) -> Path:
    path.mkdir()
    (path / "room.sens").write_bytes(data_sets.sens_bytes(FRAMES))
    return path


def azure(path: Path) -> Path:
    """Write what the two cameras of a Kinect see, colour enlarged from a quarter of its size."""
    av = pytest.importorskip("av")
    calibration = json.dumps(azure_files.document(azure_files.PINHOLE, azure_files.PINHOLE))
    lenses = read_calibration(calibration.encode(), *azure_files.SIZES)
    small = np.diag([0.25, 0.25, 1.0]) @ lenses.color.K
    T_depth_color = np.linalg.inv(lenses.T_color_depth)

    def shown(number: int) -> tuple[np.ndarray, np.ndarray]:
        T_world_depth = shot(number)[2]
        rgb = seen(small, (320, 180), T_world_depth @ T_depth_color)[0]
        depth_mm = seen(lenses.depth.K, lenses.depth.size, T_world_depth)[1]
        return cv2.resize(rgb, azure_files.SIZES[0], interpolation=cv2.INTER_CUBIC), depth_mm

    return azure_files.write_azure(av, path.with_suffix(".mkv"), FRAMES, shown)


def seen(
    K: np.ndarray, size: tuple[int, int], T_world_camera: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return colour and millimetres of the room for any camera."""

    class Posed(Room):
        @property
        def K(self) -> np.ndarray:
            return K

        def pose(self, i: int, n: int) -> np.ndarray:
            return T_world_camera

    rgb, depth_mm, _, _ = Posed(size=size).frame(0, 1)
    return rgb, depth_mm


EXACT: dict[str, Callable[[Path], Path]] = {
    "folder": folder,
    "mcap": converted,
}
"""Layouts that keep every bit of images and poses."""
LAYOUTS: dict[str, Callable[[Path], Path]] = {
    **EXACT,
    "folder as published": seven_scenes,
    "redwood": lambda path: more_data_sets.write_redwood(path, FRAMES),
    "rtabmap": lambda path: more_data_sets.write_rtabmap(path.with_suffix(".db"), FRAMES),
    "r3d": r3d,
    "rosbag": lambda path: bags.write_bag2(path, FRAMES),
    "rosbag mcap": lambda path: bags.write_bag2(path, FRAMES, mcap=True),
    "rosbag 1": lambda path: bags.write_bag1(path.with_suffix(".bag"), FRAMES),
    "tum": tum,
    "replica": replica,
    "scannet": sens,
    "scannet extracted": lambda path: data_sets.write_scannet_frames(path, FRAMES),
    "azure": azure,
}
"""The others round poses, lose a frame or pack colour: the map is much the same."""
