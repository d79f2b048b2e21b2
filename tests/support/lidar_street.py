"""A street with houses, parked cars and poles, scanned by a LiDAR of rings and seen by a camera.

Closed-form boxes, so that every beam and every pixel is exact.
"""

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import cv2
import numpy as np

from sceneq_core.ingest.source import Camera

from support.room import Thing

K = np.array([[180.0, 0, 159.5], [0, 180.0, 59.5], [0, 0, 1]])
CAMERA = Camera(K, (320, 120))
T_CAMERA_LIDAR = np.array([[0, -1, 0, 0.05], [0, 0, -1, -0.08], [1, 0, 0, -0.27], [0, 0, 0, 1.0]])
"""x forward, y left, z up becomes x right, y down, z forward, with KITTI's offsets."""
HEIGHT_M = 1.73
BEND_M = 60.0
RINGS, PER_RING = 32, 450


def street() -> tuple[Thing, ...]:
    """Return the things along 60 m of road in x, with the LiDAR's height taken off z."""
    things = [
        Thing("road", (30, 0, -HEIGHT_M - 0.1), (90, 90, 95), size=(140, 40, 0.2)),
        Thing("end", (75, 0, 3), (150, 140, 130), size=(1, 40, 10)),
        Thing("back", (-12, 0, 3), (160, 150, 140), size=(1, 40, 10)),
    ]
    for k in range(8):
        side = 1 if k % 2 else -1
        x, depth = 3.0 + 7.0 * k, 4.0 + (k * 1.7) % 3
        grey = 120 + 12 * k
        centre, size = (x, side * (8 + depth / 2), 2.0), (5.0 + (k % 3), depth, 8.0)
        things.append(Thing(f"house {k}", centre, (grey, 110, 90), size=size))
    for k, (x, y) in enumerate(((9, 3.2), (17, -3.4), (26, 3.0))):
        colour = ((190, 30, 30), (30, 60, 190), (230, 230, 235))[k]
        centre = (x, y, -HEIGHT_M + 0.75)
        things.append(Thing(f"car {k}", centre, colour, size=(4.0, 1.7, 1.5)))
    for k in range(22):
        side, x = (1 if k % 2 else -1), -6 + 2.9 * k + (k * 0.37) % 1
        colour = (60 + 5 * k, 120, 60)
        things.append(Thing(f"hedge {k}", (x, side * 6.6, -0.6), colour, size=(1.1, 0.9, 2.3)))
    return tuple(things)


@dataclass(frozen=True)
class Street:
    """Scans and images of a car that starts, up to ``step_m`` a frame, on a road with a bend."""

    things: tuple[Thing, ...] = field(default_factory=street)
    step_m: float = 0.6

    def pose(self, k: int) -> np.ndarray:
        """Return T_world_lidar (4, 4); the world is the first one."""
        way_m = self.step_m * k * k / (k + 6)
        turn = way_m / BEND_M
        T_world_lidar = np.eye(4)
        T_world_lidar[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
        T_world_lidar[:2, 3] = BEND_M * np.sin(turn), BEND_M * (1 - np.cos(turn))
        return T_world_lidar

    @cache  # noqa: B019
    def scan(self, k: int) -> np.ndarray:
        """Return float32 (N, 4) x y z reflectance in the LiDAR."""
        down = np.deg2rad(np.linspace(4, -24, RINGS))[:, None]
        around = np.linspace(-np.pi, np.pi, PER_RING, endpoint=False)[None]
        jitter = np.random.default_rng(k).normal(0, 2e-3, (2, RINGS, PER_RING))
        down, around = down + jitter[0], around + jitter[1]
        rays = np.stack(
            np.broadcast_arrays(
                np.cos(down) * np.cos(around), np.cos(down) * np.sin(around), np.sin(down)
            ),
            axis=-1,
        ).reshape(-1, 3)
        distance, first = self._hit(self.pose(k), rays)
        near = distance < 80
        points = rays[near] * distance[near, None]
        return np.hstack([points, first[near, None] / 20]).astype(np.float32)

    @cache  # noqa: B019
    def picture(self, k: int) -> tuple[np.ndarray, np.ndarray]:
        """Return rgb uint8 (H, W, 3) and the true depth, metres (H, W)."""
        width, height = CAMERA.size
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        rays = np.stack([u, v, np.ones_like(u)], axis=-1).reshape(-1, 3) @ np.linalg.inv(K).T
        T_world_camera = self.pose(k) @ np.linalg.inv(T_CAMERA_LIDAR)
        distance, first = self._hit(T_world_camera, rays)
        colours = np.array([thing.rgb for thing in self.things], np.uint8)[first]
        colours[~np.isfinite(distance)] = (150, 190, 230)
        return colours.reshape(height, width, 3), distance.reshape(height, width)

    def _hit(self, T_world_sensor: np.ndarray, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turned = rays @ T_world_sensor[:3, :3].T
        hits = np.stack([t.distance(T_world_sensor[:3, 3], turned) for t in self.things])
        return hits.min(axis=0), hits.argmin(axis=0)


def write_kitti(folder: Path, count: int, poses: bool = False) -> Street:
    """Write a sequence in the layout of KITTI odometry: image_2, velodyne, calib.txt, times.txt."""
    drive = Street()
    for part in ("image_2", "velodyne"):
        (folder / part).mkdir(parents=True)
    for k in range(count):
        rgb, _ = drive.picture(k)
        cv2.imwrite(str(folder / "image_2" / f"{k:06d}.png"), rgb[..., ::-1])
        drive.scan(k).tofile(folder / "velodyne" / f"{k:06d}.bin")
    (folder / "times.txt").write_text("".join(f"{0.1 * k:.6e}\n" for k in range(count)))
    (folder / "calib.txt").write_text(calibration())
    if poses:
        rows = [_cam0(drive, k)[:3].reshape(-1) for k in range(count)]
        (folder / "poses.txt").write_text("\n".join(" ".join(f"{n:e}" for n in r) for r in rows))
    return drive


BASELINE_M = 0.06


def calibration() -> str:
    """Return calib.txt: camera 0 is BASELINE_M to the right of camera 2."""
    lines = []
    for number in range(4):
        offset_m = BASELINE_M if number == 2 else 0.0
        projection = np.hstack([K, (K @ [offset_m, 0, 0])[:, None]])
        lines.append(f"P{number}: " + " ".join(f"{n:.12e}" for n in projection.reshape(-1)))
    lidar = T_CAMERA_LIDAR.copy()
    lidar[0, 3] -= BASELINE_M
    lines.append("Tr: " + " ".join(f"{n:.12e}" for n in lidar[:3].reshape(-1)))
    return "\n".join(lines) + "\n"


def _cam0(drive: Street, k: int) -> np.ndarray:
    """Return the pose of camera 0 in its first one, as KITTI's poses are."""
    T_cam0_lidar = T_CAMERA_LIDAR.copy()
    T_cam0_lidar[0, 3] -= BASELINE_M
    return T_cam0_lidar @ drive.pose(k) @ np.linalg.inv(T_cam0_lidar)
