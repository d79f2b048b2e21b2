"""How an RGB-D camera sees depth: noise, steps, holes and shadows."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, UInt16
from sceneq_tools.room.camera.grain import grain, patches
from sceneq_tools.room.rendering import Rendering

FLAT_COSINE = 0.5  # surfaces seen at less than 60 degrees have no noise from their slant


@dataclass(frozen=True, slots=True)
class DepthSensor:
    """Parameters of a structured-light or stereo camera such as Kinect or RealSense.

    Axial noise follows Nguyen, Izadi, Lovell 2012 (DOI 10.1109/3DIMPVT.2012.84): its standard
    deviation grows with the square of depth, and towards grazing angles.

    Attributes:
        noise_floor_m: axial noise at ``noise_from_m``.
        noise_growth: metres of noise per square metre beyond ``noise_from_m``.
        noise_from_m: depth from which noise grows.
        noise_grazing: strength of the growth with the angle, metres^1.5; none below 60 degrees.
        noise_grain_px: standard deviation of the noise's correlation: windows are matched.
        edge_jitter_px: standard deviation of the lateral error that frays edges.
        focal_baseline_px_m: focal length in pixels of the matcher times its baseline.
        disparity_step_px: smallest step of disparity; 0 for none.
        least_m, most_m: range; beyond it there is no measurement.
        least_cosine: surfaces seen at a smaller cosine are not measured.
        step_m: a larger change between neighbours is an edge, where half of the pixels fail.
        edge_loss: share of pixels on such edges that are lost.
        shadow_px: longest shadow, pixels; the projector does not see what lies in it.
        speckle_loss: share of small patches that are lost anywhere.
    """

    noise_floor_m: float = 0.0012
    noise_growth: float = 0.0019
    noise_from_m: float = 0.4
    noise_grazing: float = 0.0001
    noise_grain_px: float = 1.6
    edge_jitter_px: float = 0.5
    focal_baseline_px_m: float = 43.2
    disparity_step_px: float = 0.125
    least_m: float = 0.35
    most_m: float = 4.5
    least_cosine: float = 0.17
    step_m: float = 0.05
    edge_loss: float = 0.55
    shadow_px: int = 16
    speckle_loss: float = 0.0015

    def __post_init__(self) -> None:
        for name in ("noise_floor_m", "noise_growth", "noise_grazing", "disparity_step_px"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        for name in ("edge_loss", "speckle_loss", "least_cosine"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} must lie in 0..1, got {getattr(self, name)}")
        if not 0 <= self.least_m < self.most_m:
            raise ValueError(f"least_m must lie in 0..most_m, got {self.least_m}")
        if self.focal_baseline_px_m <= 0:
            raise ValueError(f"focal_baseline_px_m must be positive: {self.focal_baseline_px_m}")

    def measure(self, rendering: Rendering, rng: np.random.Generator) -> UInt16:
        """Return uint16 (H, W) millimetres, 0 = no measurement."""
        true_m = rendering.depth_m
        measured = self._frayed(true_m, rng)
        measured = measured + self._noise(measured, rendering.incidence, rng)
        measured = self._in_steps(measured)
        lost = self._out_of_reach(measured, rendering) | self._in_shadow(true_m)
        lost |= self._lost_at_edges(true_m, rng) | self._speckles(true_m.shape, rng)
        millimetres: UInt16 = np.where(lost, 0, np.round(measured * 1000)).astype(np.uint16)
        return millimetres

    def _frayed(self, depth_m: Float32, rng: np.random.Generator) -> Float32:
        """Take each pixel's depth from a little beside it."""
        height, width = depth_m.shape
        at = rng.standard_normal((2, height, width), np.float32)
        at *= np.float32(self.edge_jitter_px)
        at[0] += np.arange(width, dtype=np.float32)
        at[1] += np.arange(height, dtype=np.float32)[:, None]
        frayed = cv2.remap(
            depth_m,
            at[0],
            at[1],
            cv2.INTER_NEAREST,
            borderMode=cv2.BORDER_REPLICATE,
        )
        return np.asarray(frayed, np.float32)

    def _noise(self, depth_m: Float32, incidence: Float32, rng: np.random.Generator) -> Float32:
        sigma = depth_m - np.float32(self.noise_from_m)
        sigma *= sigma * np.float32(self.noise_growth)
        sigma += np.float32(self.noise_floor_m)
        grazing = np.nonzero(incidence < FLAT_COSINE)
        angle = np.arccos(np.maximum(incidence[grazing], 0))
        left = np.maximum(np.pi / 2 - angle, np.float32(0.03))
        near = np.sqrt(np.maximum(depth_m[grazing], np.float32(0.2)))
        sigma[grazing] += self.noise_grazing / near * (angle / left) ** 2
        sigma *= grain(depth_m.shape, self.noise_grain_px, rng)
        return sigma

    def _in_steps(self, depth_m: Float32) -> Float32:
        """Round disparity, so that steps of depth grow with its square."""
        if self.disparity_step_px == 0:
            return depth_m
        disparity = self.focal_baseline_px_m / np.maximum(depth_m, np.float32(0.05))
        steps = np.maximum(np.round(disparity / self.disparity_step_px), 1)
        return (self.focal_baseline_px_m / (steps * self.disparity_step_px)).astype(np.float32)

    def _out_of_reach(self, measured_m: Float32, rendering: Rendering) -> Bool:
        nothing = rendering.depth_m <= 0
        outside = (measured_m < self.least_m) | (measured_m > self.most_m)
        return nothing | outside | (rendering.incidence < self.least_cosine)

    def _in_shadow(self, depth_m: Float32) -> Bool:
        """Find background left of something nearer that is hidden from the projector."""
        known = np.where(depth_m > 0, depth_m, np.float32(1e3))
        disparity = np.float32(self.focal_baseline_px_m) / known
        shadow = np.zeros(depth_m.shape, bool)
        for shift in range(1, min(self.shadow_px, depth_m.shape[1] - 1) + 1):
            hidden = disparity[:, shift:] - disparity[:, :-shift] > shift
            step = known[:, :-shift] - known[:, shift:] > self.step_m
            shadow[:, :-shift] |= hidden & step
        return shadow

    def _lost_at_edges(self, depth_m: Float32, rng: np.random.Generator) -> Bool:
        kernel = np.ones((3, 3), np.uint8)
        rise = cv2.dilate(depth_m, kernel) - cv2.erode(depth_m, kernel)
        edge = rise > self.step_m * np.maximum(depth_m, 1)
        return edge & patches(depth_m.shape, self.edge_loss, rng)

    def _speckles(self, shape: tuple[int, ...], rng: np.random.Generator) -> Bool:
        return patches(shape, self.speckle_loss, rng)
