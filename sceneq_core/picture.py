"""A picture of the instance cloud: point splats with a depth buffer and eye-dome shading."""

from collections.abc import Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32, Int64, UInt8

BACKGROUND = (250, 250, 248)
GOLDEN_RATIO = 0.618033988749895


@dataclass(frozen=True, slots=True)
class Viewpoint:
    """A pinhole camera that looks at a scene: ``T_camera_world`` (4, 4) metres, ``K`` (3, 3)."""

    T_camera_world: Float64
    K: Float64
    size: tuple[int, int]

    def project(self, points_world: Float64) -> tuple[Float64, Float64]:
        """Return pixels (N, 2) and depths in metres (N,); a depth <= 0 is behind the camera."""
        points_camera = points_world @ self.T_camera_world[:3, :3].T + self.T_camera_world[:3, 3]
        depth_m = points_camera[:, 2]
        pixels = points_camera @ self.K.T
        return pixels[:, :2] / np.maximum(depth_m, 1e-9)[:, None], depth_m


def overview(
    points_world: Float32,
    up_world: Float64,
    size: tuple[int, int] = (1280, 800),
    elevation_deg: float = 40.0,
) -> Viewpoint:
    """Return a raised viewpoint from the most open side of the points (N, 3) that sees all."""
    centre = np.median(points_world, axis=0).astype(np.float64)
    elevation = np.radians(elevation_deg)
    away = _open_side(points_world - centre, up_world)
    direction = np.cos(elevation) * away + np.sin(elevation) * up_world
    radius = float(np.percentile(np.linalg.norm(points_world - centre, axis=1), 97))
    position = centre + 3.0 * max(radius, 0.1) * direction
    return _fitted(_look_at(position, centre, up_world), points_world, size)


def _open_side(offsets: Float64, up_world: Float64) -> Float64:
    """Return the horizontal direction with the fewest high points: no wall hides the room."""
    axes = np.linalg.svd(up_world[None])[2][1:]
    angles = np.radians(np.arange(0, 360, 15))
    directions = np.cos(angles)[:, None] * axes[0] + np.sin(angles)[:, None] * axes[1]
    height = offsets @ up_world
    high = offsets[height > np.percentile(height, 60)]
    in_the_way = np.maximum(high @ directions.T, 0).sum(axis=0)
    side: Float64 = directions[int(np.argmin(in_the_way))]
    return side


def _fitted(T_camera_world: Float64, points_world: Float32, size: tuple[int, int]) -> Viewpoint:
    """Return the viewpoint whose focal length and centre make the points fill the image."""
    unit = Viewpoint(T_camera_world, np.eye(3), size)
    pixels, _ = unit.project(points_world.astype(np.float64))
    low, high = np.percentile(pixels, [0.5, 99.5], axis=0)
    focal = 0.92 * float(np.min(np.asarray(size) / np.maximum(high - low, 1e-6)))
    cx, cy = np.asarray(size) / 2 - focal * (low + high) / 2
    return Viewpoint(T_camera_world, np.array([[focal, 0, cx], [0, focal, cy], [0, 0, 1.0]]), size)


def instance_colours(instance_id: Int32, rgb: UInt8) -> UInt8:
    """Return a distinct colour per instance (N, 3); points of no instance are faint grey.

    Half of the brightness comes from the real colour, so that shapes stay readable.
    """
    hue = (instance_id * GOLDEN_RATIO) % 1.0 * 180
    saturation = 150 + (instance_id * 37) % 90
    hsv = np.stack([hue, saturation, np.full_like(hue, 235)], axis=1).astype(np.uint8)
    flat = cv2.cvtColor(hsv[None], cv2.COLOR_HSV2RGB)[0].astype(np.float32)
    grey = rgb.mean(axis=1, keepdims=True)
    flat[instance_id == 0] = 190
    colours: UInt8 = (flat * (0.6 + 0.4 * grey / 255)).astype(np.uint8)
    return colours


def draw_cloud(viewpoint: Viewpoint, points_world: Float32, rgb: UInt8, point_m: float) -> UInt8:
    """Return an RGB image (H, W, 3) of the points, each a square of ``point_m`` metres."""
    width, height = viewpoint.size
    pixels, depth_m = viewpoint.project(points_world.astype(np.float64))
    near_last = np.argsort(-depth_m, kind="stable")
    near_last = near_last[depth_m[near_last] > 0.05]
    image = np.full((height, width, 3), BACKGROUND, np.uint8)
    buffer_m = np.full((height, width), np.inf, np.float32)
    corner = np.rint(pixels[near_last]).astype(np.int64)
    focal = viewpoint.K[0, 0]
    side = int(np.clip(np.ceil(1.3 * point_m * focal / np.median(depth_m)), 1, 15))
    for dv, du in np.ndindex(side, side):
        u, v = corner[:, 0] + du - side // 2, corner[:, 1] + dv - side // 2
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        source = near_last[inside]
        _splat(image, buffer_m, v[inside], u[inside], depth_m[source], rgb[source])
    return _eye_dome(image, buffer_m)


def draw_labels(image: UInt8, viewpoint: Viewpoint, labels: Mapping[str, Float64]) -> UInt8:
    """Return the image with each text at its world position (3,)."""
    out = image.copy()
    for text, position in labels.items():
        (pixel,), (depth_m,) = viewpoint.project(position[None])
        if depth_m > 0:
            _write(out, text, (int(pixel[0]), int(pixel[1])))
    return out


def _splat(
    image: UInt8, buffer_m: Float32, v: Int64, u: Int64, depth_m: Float64, rgb: UInt8
) -> None:
    """Write points ordered far to near: of several on one pixel the last, nearest, stays."""
    nearer = depth_m < buffer_m[v, u]
    v, u = v[nearer], u[nearer]
    image[v, u] = rgb[nearer]
    buffer_m[v, u] = depth_m[nearer]


def _eye_dome(image: UInt8, buffer_m: Float32) -> UInt8:
    """Darken pixels that lie behind their neighbours (Boucheny 2009), so that edges show."""
    log_depth = np.log2(np.where(np.isfinite(buffer_m), buffer_m, 1e3))
    shade = np.zeros_like(log_depth)
    for shift, axis in ((3, 0), (-3, 0), (3, 1), (-3, 1)):
        shade += np.maximum(0, log_depth - np.roll(log_depth, shift, axis))
    factor = np.exp(-np.minimum(shade, 0.25) * 4.0)
    factor[~np.isfinite(buffer_m)] = 1.0
    shaded: UInt8 = (image * factor[..., None]).astype(np.uint8)
    return shaded


def _write(image: UInt8, text: str, at: tuple[int, int]) -> None:
    font, scale = cv2.FONT_HERSHEY_SIMPLEX, 0.45
    (width, height), _ = cv2.getTextSize(text, font, scale, 1)
    x, y = at[0] - width // 2, at[1] + height // 2
    cv2.rectangle(image, (x - 3, y - height - 3), (x + width + 3, y + 4), (255, 255, 255), -1)
    cv2.putText(image, text, (x, y), font, scale, (20, 20, 20), 1, cv2.LINE_AA)


def _look_at(position: Float64, target: Float64, up: Float64) -> Float64:
    """Return T_camera_world (4, 4) with OpenCV axes: x right, y down, z forward."""
    z = (target - position) / np.linalg.norm(target - position)
    x = np.cross(z, up)
    x /= np.linalg.norm(x)
    R_camera_world = np.stack([x, np.cross(z, x), z])
    T_camera_world = np.eye(4)
    T_camera_world[:3, :3] = R_camera_world
    T_camera_world[:3, 3] = -R_camera_world @ position
    return T_camera_world
