"""A small furnished room, ray-cast analytically: exact colour, depth, instances and poses.

Boxes and spheres on a floor between walls, seen by a camera on an arc. Everything is closed-form,
so a 160x120 frame takes milliseconds and no mesh or renderer is needed.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

Float = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Thing:
    """A box (``size`` = edges) or a sphere (``radius``) with a colour, in metres, z up."""

    name: str
    centre: tuple[float, float, float]
    rgb: tuple[int, int, int]
    size: tuple[float, float, float] | None = None
    radius: float = 0.0

    def distance(self, origin: Float, rays: Float) -> Float:
        """Return per ray the distance to the first hit from outside, inf where it misses."""
        return self._box(origin, rays) if self.size else self._sphere(origin, rays)

    def _box(self, origin: Float, rays: Float) -> Float:
        half = np.asarray(self.size) / 2
        with np.errstate(divide="ignore", invalid="ignore"):
            a = (np.asarray(self.centre) - half - origin) / rays
            b = (np.asarray(self.centre) + half - origin) / rays
        near = np.nanmax(np.minimum(a, b), axis=-1)
        far = np.nanmin(np.maximum(a, b), axis=-1)
        return np.where((near <= far) & (near > 1e-6), near, np.inf)

    def _sphere(self, origin: Float, rays: Float) -> Float:
        offset = origin - np.asarray(self.centre)
        a = (rays**2).sum(-1)
        b = rays @ offset
        root = b**2 - a * (offset @ offset - self.radius**2)
        t = (-b - np.sqrt(np.where(root > 0, root, np.nan))) / a
        return np.where(t > 1e-6, t, np.inf)


THINGS = (
    Thing("floor", (0, 0, -0.05), (150, 120, 90), size=(6, 6, 0.1)),
    Thing("wall", (0, 2.05, 1.25), (215, 215, 205), size=(6, 0.1, 2.5)),
    Thing("table", (0.0, 1.0, 0.36), (120, 72, 40), size=(1.2, 0.7, 0.72)),
    Thing("red ball", (-0.35, 0.95, 0.84), (205, 30, 30), radius=0.12),
    Thing("blue box", (0.3, 1.0, 0.82), (30, 60, 200), size=(0.22, 0.22, 0.2)),
    Thing("green box", (-1.2, 1.2, 0.25), (40, 160, 60), size=(0.5, 0.5, 0.5)),
    Thing("yellow ball", (1.2, 0.8, 0.2), (230, 200, 40), radius=0.2),
)


@dataclass(frozen=True)
class Room:
    """The scene and the camera; ``frame(i, n)`` is view ``i`` of ``n`` along an arc."""

    things: tuple[Thing, ...] = THINGS
    size: tuple[int, int] = (160, 120)
    focal_px: float = 130.0
    light: Float = field(default_factory=lambda: np.array([0.3, -0.8, 1.0]) / 1.32)

    @property
    def K(self) -> Float:
        w, h = self.size
        return np.array(
            [[self.focal_px, 0, w / 2 - 0.5], [0, self.focal_px, h / 2 - 0.5], [0, 0, 1.0]]
        )

    def pose(self, i: int, n: int) -> Float:
        """Return T_world_camera (4, 4) on an arc of 60 degrees, 2.4 m before the table."""
        angle = np.radians(-30 + 60 * i / max(n - 1, 1))
        position = np.array([2.4 * np.sin(angle), 1.0 - 2.4 * np.cos(angle), 1.5])
        return look_at(position, np.array([0.0, 1.0, 0.5]))

    def frame(
        self, i: int, n: int
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint16], npt.NDArray[np.uint16], Float]:
        """Return rgb uint8, depth_mm uint16, instance uint16 (index + 1 of things), pose."""
        T_world_camera = self.pose(i, n)
        rays = self._rays() @ T_world_camera[:3, :3].T
        origin = T_world_camera[:3, 3]
        depth = np.stack([t.distance(origin, rays) for t in self.things])
        first = depth.argmin(axis=0)
        depth_m = depth.min(axis=0)
        hit = np.isfinite(depth_m) & (depth_m < 8)
        points = origin + rays * np.where(hit, depth_m, 0)[..., None]
        rgb = self._shade(first, points, hit)
        depth_mm = np.where(hit, np.rint(depth_m * 1000), 0).astype(np.uint16)
        return rgb, depth_mm, np.where(hit, first + 1, 0).astype(np.uint16), T_world_camera

    def _rays(self) -> Float:
        """Return (H, W, 3) camera rays with z = 1, so that distance along a ray is depth."""
        w, h = self.size
        u, v = np.meshgrid(np.arange(w), np.arange(h))
        return np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(self.K).T

    def _shade(
        self, first: npt.NDArray[np.intp], points: Float, hit: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.uint8]:
        colours = np.array([t.rgb for t in self.things], dtype=float)[first]
        normals = np.stack([_normal(t, points) for t in self.things])
        normal = np.take_along_axis(normals, first[None, ..., None], axis=0)[0]
        brightness = 0.55 + 0.45 * np.clip(normal @ self.light, 0, 1)
        return np.where(hit[..., None], colours * brightness[..., None], 0).astype(np.uint8)


def _normal(thing: Thing, points: Float) -> Float:
    offset = points - np.asarray(thing.centre)
    if thing.size is None:
        return offset / np.maximum(np.linalg.norm(offset, axis=-1, keepdims=True), 1e-9)
    scaled = offset / (np.asarray(thing.size) / 2)
    axis = np.abs(scaled).argmax(axis=-1)
    return np.eye(3)[axis] * np.sign(np.take_along_axis(scaled, axis[..., None], axis=-1))


def look_at(position: Float, target: Float) -> Float:
    """Return T_world_camera (4, 4), OpenCV axes, world z up."""
    z = (target - position) / np.linalg.norm(target - position)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    T_world_camera[:3, 3] = position
    return T_world_camera
