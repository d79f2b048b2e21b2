"""A room whose walls have a pattern that is nowhere the same, seen from inside; ray-cast."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from sceneq_core.frame import Frame, depth_from_mm

from support.room import look_at

Float = npt.NDArray[np.float64]
BOXES = (
    ((1.5, 1.2, 0.4), (0.7, 0.5, 0.8)),
    ((-1.6, 1.0, 0.3), (0.5, 0.5, 0.6)),
    ((0.9, -1.4, 0.5), (0.6, 0.4, 1.0)),
    ((-1.2, -1.3, 0.25), (0.9, 0.5, 0.5)),
)


@dataclass(frozen=True)
class PaperedRoom:
    """Five by four metres with four boxes in it; ``seed`` draws the pattern.

    ``is_symmetric``: turned by half round it looks the same; ``is_plain``: without any pattern.
    """

    seed: int = 0
    is_symmetric: bool = False
    is_plain: bool = False
    size: tuple[int, int] = (192, 144)
    focal_px: float = 156.0
    half: tuple[float, float, float] = (2.5, 2.0, 1.25)

    @property
    def K(self) -> Float:
        w, h = self.size
        return np.array(
            [[self.focal_px, 0, w / 2 - 0.5], [0, self.focal_px, h / 2 - 0.5], [0, 0, 1.0]]
        )

    def frame(self, seq: int, turn_deg: float, x: float = 0.0, y: float = 0.0) -> Frame:
        """Return what a camera sees that looks outward, with its true pose."""
        return self.seen(seq, turn_deg, x, y)[0]

    @lru_cache(maxsize=128)  # noqa: B019
    def seen(
        self, seq: int, turn_deg: float, x: float = 0.0, y: float = 0.0
    ) -> tuple[Frame, npt.NDArray[np.uint16]]:
        """Return the frame and what each pixel shows: 1 = walls, 2.. = boxes."""
        turn = np.radians(turn_deg)
        origin = np.array([x, y, 1.3])
        aim = origin + np.array([np.cos(turn), np.sin(turn), -0.25])
        pose = look_at(origin, aim)
        rays = self._rays() @ pose[:3, :3].T
        depth, surface = self._hit(origin, rays)
        points = origin + rays * depth[..., None]
        depth_mm = np.rint(depth * 1000).astype(np.uint16)
        rgb = self._paint(points, surface)
        frame = Frame(seq, seq * 100_000_000, rgb, depth_from_mm(depth_mm), self.K, pose)
        return frame, (surface + 1).astype(np.uint16)

    def walk(self, first: int, count: int, start_deg: float, step_deg: float) -> list[Frame]:
        """Return frames of a camera that turns as it goes in a small circle."""
        turns = [start_deg + step_deg * i for i in range(count)]
        return [
            self.frame(first + i, t, 0.4 * np.cos(np.radians(3 * t)), 0.4 * np.sin(np.radians(t)))
            for i, t in enumerate(turns)
        ]

    def _boxes(self) -> list[tuple[Float, Float]]:
        boxes = [(np.array(c), np.array(s)) for c, s in BOXES]
        if self.is_symmetric:
            boxes = boxes[:2] + [(c * [-1, -1, 1], s) for c, s in boxes[:2]]
        return boxes

    def _hit(self, origin: Float, rays: Float) -> tuple[Float, npt.NDArray[np.intp]]:
        half = np.asarray(self.half)
        lift = np.array([0, 0, half[2]])
        with np.errstate(divide="ignore", invalid="ignore"):
            wall = np.nanmin(
                np.maximum((half + lift - origin) / rays, (lift - half - origin) / rays), axis=-1
            )
            all_hits = [wall]
            for centre, size in self._boxes():
                a, b = (centre - size / 2 - origin) / rays, (centre + size / 2 - origin) / rays
                near = np.nanmax(np.minimum(a, b), axis=-1)
                far = np.nanmin(np.maximum(a, b), axis=-1)
                all_hits.append(np.where((near <= far) & (near > 1e-6), near, np.inf))
        hits = np.stack(all_hits)
        return hits.min(axis=0), hits.argmin(axis=0)

    def _paint(self, points: Float, surface: npt.NDArray[np.intp]) -> npt.NDArray[np.uint8]:
        if self.is_plain:
            return np.full((*surface.shape, 3), 150, np.uint8)
        if self.is_symmetric:
            points = np.where(points[..., :1] < 0, points * [-1, -1, 1], points)
            surface = np.where(surface > 2, surface - 2, surface)
        shades = [self._noise(points, cell, k) for k, cell in enumerate((0.4, 0.15, 0.08))]
        bright = 20 + 220 * np.clip(0.3 * shades[0] + 0.3 * shades[1] + 0.4 * shades[2], 0, 1)
        tint = np.random.default_rng(self.seed + 9).uniform(0.6, 1.0, (8, 3))[surface]
        return (bright[..., None] * tint).astype(np.uint8)

    def _noise(self, points: Float, cell_m: float, octave: int) -> Float:
        """Return values 0..1, another one in every cell of space."""
        values = np.random.default_rng((self.seed, octave)).random(1 << 16)
        cell = np.floor(points / cell_m + 1000.37).astype(np.int64)
        found: Float = values[cell @ np.array([73856093, 19349663, 83492791]) & 0xFFFF]
        return found

    def _rays(self) -> Float:
        w, h = self.size
        u, v = np.meshgrid(np.arange(w), np.arange(h))
        return np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(self.K).T
