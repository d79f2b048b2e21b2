"""Where points of a scene fall in a picture: from straight above and from its upper corners."""

from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64

MARGIN = 0.93
"""Share of the picture that the points fill."""
STRAYS_PERCENT = 0.4
"""A few points far out must not make everything else small."""
SMALLEST = 0.25
"""Nothing is enlarged further, not even a single point: metres of a plan, else tangents."""
CELL_M = 0.05
SAMPLE = 40_000
CLEARER = 1.03
LEVEL = 0.7
"""The first axis that is less upright than this becomes x; there always is one."""


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """A camera that looks at a scene, OpenCV axes: x right, y down, z forward.

    Attributes:
        T_camera_world: (4, 4), metres.
        K: (3, 3), pixels; an orthographic camera has pixels per metre as focal length.
        size: width, height in pixels.
        orthographic: everything is equally large, as on a plan.
    """

    T_camera_world: Float64
    K: Float64
    size: tuple[int, int]
    orthographic: bool = False

    def project(self, points_world: Float64) -> tuple[Float64, Float64]:
        """Return pixels (N, 2) and depths in metres (N,); a depth <= 0 is behind the camera."""
        points_camera = points_world @ self.T_camera_world[:3, :3].T + self.T_camera_world[:3, 3]
        depth_m = points_camera[:, 2]
        scale = np.ones_like(depth_m) if self.orthographic else np.maximum(depth_m, 1e-9)
        return points_camera[:, :2] / scale[:, None] * self.K[0, 0] + self.K[:2, 2], depth_m

    def pixels_per_metre(self, depth_m: Float64) -> Float64:
        """Return how many pixels a metre at ``depth_m`` (N,) is long."""
        focal = float(self.K[0, 0])
        if self.orthographic:
            return np.full_like(depth_m, focal)
        scale: Float64 = focal / np.maximum(depth_m, 1e-9)
        return scale

    def enlarged(self, factor: int) -> "Viewpoint":
        """Return the same view with ``factor`` times as many pixels a side."""
        K = self.K * np.array([[factor], [factor], [1.0]])
        K[:2, 2] += (factor - 1) / 2  # pixel centres are at whole numbers
        size = (self.size[0] * factor, self.size[1] * factor)
        return Viewpoint(self.T_camera_world, K, size, self.orthographic)


def room_axes(points_world: Float32, up_world: Float64) -> Float64:
    """Return R_room_world (3, 3): z up, x and y along the walls, x as near as may be to an axis.

    Along the walls many points share a coordinate: the histograms of x and y are at their
    sharpest there. Of the four turns that are equally sharp, the one is taken that turns the
    world's most level axis least, so that the plan of a scene looks the same from run to run.
    """
    up = up_world / np.linalg.norm(up_world)
    level = int(np.argmax(np.abs(up) < LEVEL))
    x = np.eye(3)[level] - up[level] * up
    x /= np.linalg.norm(x)
    y = np.cross(up, x)
    step = max(1, len(points_world) // SAMPLE)
    plan = points_world[::step].astype(np.float64) @ np.stack([x, y]).T
    angle = np.radians(_wall_angle_deg(plan))
    turned = np.cos(angle) * x + np.sin(angle) * y
    return np.stack([turned, np.cross(up, turned), up])


def _wall_angle_deg(plan: Float64) -> int:
    """Return the angle in [-45, 45) by which the axes of ``plan`` (N, 2) lie along the walls."""
    sharpness = {angle: _sharpness(plan, angle) for angle in range(-45, 45)}
    best = max(sharpness, key=lambda angle: (sharpness[angle], -abs(angle)))
    return best if sharpness[best] > CLEARER * sharpness[0] else 0


def _sharpness(plan: Float64, angle_deg: int) -> float:
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    total = 0.0
    for along in (plan @ [c, s], plan @ [-s, c]):
        cells = np.floor((along - along.min()) / CELL_M).astype(np.int64)
        total += float((np.bincount(cells).astype(np.float64) ** 2).sum())
    return total


def from_above(points_world: Float64, R_room_world: Float64, size: tuple[int, int]) -> Viewpoint:
    """Return the orthographic view straight down in which the points fill ``size``; x is right."""
    R_camera_world = R_room_world * np.array([[1.0], [-1.0], [-1.0]])
    T_camera_world = np.eye(4)
    T_camera_world[:3, :3] = R_camera_world
    T_camera_world[2, 3] = 1.0 - float((points_world @ R_camera_world[2]).min())
    return _fitted(T_camera_world, points_world, size, orthographic=True)


def from_corner(
    points_world: Float64,
    R_room_world: Float64,
    azimuth_deg: float,
    size: tuple[int, int],
    elevation_deg: float = 38.0,
) -> Viewpoint:
    """Return the view from a raised place at ``azimuth_deg`` from the room's x, all in sight."""
    azimuth, elevation = np.radians(azimuth_deg), np.radians(elevation_deg)
    level = np.cos(elevation)
    towards = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
    low, high = _extent(points_world)
    centre, radius = (low + high) / 2, float(np.linalg.norm(high - low)) / 2
    position = centre + 2.4 * max(radius, 0.1) * (np.asarray(towards) @ R_room_world)
    return _fitted(_look_at(position, centre, R_room_world[2]), points_world, size)


def _extent(values: Float64) -> tuple[Float64, Float64]:
    low, high = np.percentile(values, [STRAYS_PERCENT, 100 - STRAYS_PERCENT], axis=0)
    return low, high


def _fitted(
    T_camera_world: Float64,
    points_world: Float64,
    size: tuple[int, int],
    orthographic: bool = False,
) -> Viewpoint:
    """Return the viewpoint whose focal length and centre make the points fill the picture."""
    pixels, _ = Viewpoint(T_camera_world, np.eye(3), size, orthographic).project(points_world)
    low, high = _extent(pixels)
    focal = MARGIN * float(np.min(np.asarray(size) / np.maximum(high - low, SMALLEST)))
    cx, cy = np.asarray(size) / 2 - focal * (low + high) / 2
    K = np.array([[focal, 0, cx], [0, focal, cy], [0, 0, 1.0]])
    return Viewpoint(T_camera_world, K, size, orthographic)


def _look_at(position: Float64, target: Float64, up: Float64) -> Float64:
    """Return T_camera_world (4, 4) with OpenCV axes."""
    z = (target - position) / np.linalg.norm(target - position)
    x = np.cross(z, up)
    x /= np.linalg.norm(x)
    R_camera_world = np.stack([x, np.cross(z, x), z])
    T_camera_world = np.eye(4)
    T_camera_world[:3, :3] = R_camera_world
    T_camera_world[:3, 3] = -R_camera_world @ position
    return T_camera_world
