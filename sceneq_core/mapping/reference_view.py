"""A keyframe as a witness: what it measured as surface, and what it saw to be free."""

from copy import copy
from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Float32, Float64
from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.depth import pixel_rays
from sceneq_core.frame import Frame

_FINE_PX = 160
"""Pixels along the longer side of the depth in which edges are looked for."""

_EMPTY_M = np.float32(1e3)
"""The nearest surface where nothing was measured."""


@dataclass(frozen=True, slots=True)
class ReferenceParams:
    """Which samples of a depth image are compared, and when two depths are one surface.

    Samples lie between ``near_m`` and ``far_m``, the range in which the noise of the sensor is
    small; pixels with a relative depth step of ``edge_per_m`` to a neighbour say nothing. Depths
    agree up to ``margin_m`` plus ``noise_per_m`` (1/m) times the squared depth: a little more than
    the drift of a pose and the noise of structured light.
    """

    near_m: float = 0.3
    far_m: float = 5.0
    edge_per_m: float = 0.1
    margin_m: float = 0.1
    noise_per_m: float = 0.03

    def __post_init__(self) -> None:
        need_positive(self, "near_m", "edge_per_m", "margin_m")
        need_at_least(self, 0, "noise_per_m")
        if not self.far_m > self.near_m:
            raise ValueError(f"far_m: must exceed near_m, got {self.far_m}")


@dataclass(frozen=True, slots=True)
class Witnessed:
    """What a view says of N points: ``agrees``, it measured a surface there; ``free``, none.

    Where both are false the view did not see the point, or a nearer surface hid it.
    """

    agrees: Bool
    free: Bool


class ReferenceView:
    """A small copy of one keyframe's depth, about 35 KB for any size of image.

    Attributes:
        seq: of the frame.
        stamp_ns: when it was taken.
        T_world_camera: float64 (4, 4) as the frame claims it.
        points_world: float32 (N, 3) samples of its surface, edges left out.
        look_world: float64 (3,) the middle of what it looks at.
    """

    def __init__(self, frame: Frame, params: ReferenceParams) -> None:
        self.seq, self.stamp_ns = frame.seq, frame.stamp_ns
        self.T_world_camera = frame.T_world_camera.copy()
        self._params, self._K = params, frame.K
        fine = max(1, round(max(frame.depth_m.shape) / _FINE_PX))
        self._step = 2 * fine
        depth_m = np.minimum(frame.depth_m[::fine, ::fine], _EMPTY_M)
        near, far, self._whole = _extremes(depth_m)
        self._near, self._far = near.astype(np.float16), far.astype(np.float16)
        z, row, column = self._samples(depth_m[::4, ::4], near[::2, ::2], far[::2, ::2])
        x, y = pixel_rays(frame.K, frame.depth_m.shape, 4 * fine)
        points_camera = np.stack((x[column] * z, y[row] * z, z), axis=1)
        rotation, origin = self.T_world_camera[:3, :3], self.T_world_camera[:3, 3]
        self.points_world = (points_camera @ rotation.T + origin).astype(np.float32)
        self.look_world = origin + rotation[:, 2] * (np.median(z) if len(z) else 0.0)

    def witness(self, points_world: Array) -> Witnessed:
        """Say what this view knows of ``points_world`` (N, 3)."""
        rotation, origin = self.T_world_camera[:3, :3], self.T_world_camera[:3, 3]
        x, y, z = ((points_world - origin) @ rotation).T
        height, width = self._near.shape
        ahead = np.maximum(z, self._params.near_m)
        u = np.rint((x / ahead * self._K[0, 0] + self._K[0, 2]) / self._step)
        v = np.rint((y / ahead * self._K[1, 1] + self._K[1, 2]) / self._step)
        inside = (z > self._params.near_m) & (u >= 0) & (u < width) & (v >= 0) & (v < height)
        row, column = np.where(inside, v, 0).astype(int), np.where(inside, u, 0).astype(int)
        near = self._near[row, column].astype(np.float64)
        far = self._far[row, column].astype(np.float64)
        margin = self._params.margin_m + self._params.noise_per_m * z * z
        known = inside & (far > 0.0)
        before = z < near - margin
        free = known & before & self._whole[row, column]
        return Witnessed(known & ~before & (z <= far + margin), free)

    def moved(self, T_world_camera: Float64) -> "ReferenceView":
        """Return this view with the camera at another pose."""
        step = T_world_camera @ np.linalg.inv(self.T_world_camera)
        other = copy(self)
        other.T_world_camera = T_world_camera.copy()
        other.points_world = (self.points_world @ step[:3, :3].T + step[:3, 3]).astype(np.float32)
        other.look_world = step[:3, :3] @ self.look_world + step[:3, 3]
        return other

    def _samples(
        self, depth_m: Float32, near: Float32, far: Float32
    ) -> tuple[Float64, Array, Array]:
        params = self._params
        usable = (depth_m > params.near_m) & (depth_m < params.far_m)
        usable &= far - near < params.edge_per_m * depth_m
        row, column = np.nonzero(usable)
        return depth_m[row, column].astype(np.float64), row, column


def _extremes(depth_m: Float32) -> tuple[Float32, Float32, Bool]:
    """Return the nearest and farthest depth round every second pixel, and where none is missing."""
    kernel = np.ones((3, 3), np.uint8)
    lowest = cv2.erode(depth_m, kernel)[::2, ::2]
    nearest = cv2.erode(np.where(depth_m > 0, depth_m, _EMPTY_M), kernel)[::2, ::2]
    farthest = cv2.dilate(depth_m, kernel)[::2, ::2]
    return nearest.astype(np.float32), farthest.astype(np.float32), np.asarray(lowest > 0)
