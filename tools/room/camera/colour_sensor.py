"""How a small camera sees colour: blur, dark corners, noise."""

from dataclasses import dataclass

import cv2
import numpy as np

from sceneq_core.arrays import Float32, Float64, UInt8
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.camera.grain import grain
from sceneq_tools.room.rendering import Rendering
from sceneq_tools.room.textures.linear import GAMMA, LINEAR_OF_BYTE

MOST_STEPS = 9  # copies that a blurred image is made of
STEPS = 8192  # of light, of which the 256 values of sRGB are made
FAR_M = 10.0  # where nothing was met, the background moves as at this depth


@dataclass(frozen=True, slots=True)
class ColourSensor:
    """Parameters of a rolling colour camera; light is relative to white = 1.

    Attributes:
        blur_px: standard deviation of the lens' point spread.
        vignetting: share of light lost in the corners of the picture.
        photons: electrons at white; shot noise is their square root.
        read_noise: standard deviation of the noise in the dark, in electrons.
        grain_px: standard deviation of the noise's correlation: demosaicing and compression.
        shutter: exposure time as a share of the time between two frames; 0 for no motion blur.
    """

    blur_px: float = 0.45
    vignetting: float = 0.15
    photons: float = 8000.0
    read_noise: float = 8.0
    grain_px: float = 0.6
    shutter: float = 0.0

    def __post_init__(self) -> None:
        for name in ("blur_px", "read_noise", "grain_px"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must not be negative, got {getattr(self, name)}")
        for name in ("vignetting", "shutter"):
            if not 0 <= getattr(self, name) <= 1:
                raise ValueError(f"{name} must lie in 0..1, got {getattr(self, name)}")
        if self.photons <= 0:
            raise ValueError(f"photons must be positive, got {self.photons}")

    def measure(
        self, rendering: Rendering, rng: np.random.Generator, motion: "Motion | None" = None
    ) -> UInt8:
        """Return sRGB uint8 (H, W, 3); ``motion`` blurs it when the shutter is open at all."""
        light: Float32 = np.asarray(cv2.LUT(rendering.rgb, LINEAR_OF_BYTE[None]), np.float32)
        if motion is not None and self.shutter > 0:
            light = motion.blurred(light, rendering.depth_m, self.shutter)
        if self.blur_px > 0:
            cv2.GaussianBlur(light, (0, 0), self.blur_px, dst=light)
        light *= self._lens(light.shape)[..., None]
        light += self._noise(light, rng)
        return _encoded(light)

    def _lens(self, shape: tuple[int, ...]) -> Float32:
        height, width = shape[:2]
        across = (2 * np.arange(width, dtype=np.float32) - width + 1) / width
        down = (2 * np.arange(height, dtype=np.float32) - height + 1) / height
        half = np.float32(self.vignetting / 2)
        lens = np.subtract.outer(1 - half * down**2, half * across**2)
        return lens.astype(np.float32)

    def _noise(self, light: Float32, rng: np.random.Generator) -> Float32:
        sigma: Float32 = light * np.float32(self.photons)
        sigma += np.float32(self.read_noise**2)
        np.sqrt(sigma, out=sigma)
        sigma /= np.float32(self.photons)
        sigma *= grain(light.shape, self.grain_px, rng)
        return sigma


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """How the camera moves until the next frame.

    Attributes:
        T_next_camera: (4, 4) from this camera to the next one's coordinates.
        camera: intrinsics of both.
    """

    T_next_camera: Float64
    camera: Camera

    def blurred(self, light: Float32, depth_m: Float32, shutter: float) -> Float32:
        """Average the picture along the way its points take while the shutter is open."""
        flow = self._flow(depth_m) * np.float32(shutter)
        longest = float(np.percentile(np.linalg.norm(flow, axis=2), 95))
        steps = int(np.clip(np.ceil(longest), 1, MOST_STEPS))
        height, width = depth_m.shape
        y, x = np.mgrid[:height, :width].astype(np.float32)
        total = np.zeros_like(light)
        for share in (np.arange(steps) - (steps - 1) / 2) / steps:
            from_x, from_y = x - share * flow[..., 0], y - share * flow[..., 1]
            total += cv2.remap(
                light,
                from_x.astype(np.float32),
                from_y.astype(np.float32),
                cv2.INTER_LINEAR,
                borderMode=cv2.BORDER_REPLICATE,
            )
        return total / np.float32(steps)

    def _flow(self, depth_m: Float32) -> Float32:
        """Return (H, W, 2) pixels that each point moves until the next frame."""
        K = self.camera.K
        height, width = depth_m.shape
        y, x = np.mgrid[:height, :width].astype(np.float64)
        z = np.where(depth_m > 0, depth_m, FAR_M)
        points = np.stack([(x - K[0, 2]) / K[0, 0] * z, (y - K[1, 2]) / K[1, 1] * z, z], axis=2)
        moved = points @ self.T_next_camera[:3, :3].T + self.T_next_camera[:3, 3]
        ahead = np.maximum(moved[..., 2], 0.05)
        to_x = moved[..., 0] / ahead * K[0, 0] + K[0, 2]
        to_y = moved[..., 1] / ahead * K[1, 1] + K[1, 2]
        flow: Float32 = np.stack([to_x - x, to_y - y], axis=2).astype(np.float32)
        return flow


_BYTE_OF_STEP: UInt8 = np.round((np.arange(STEPS + 1) / STEPS) ** (2 / GAMMA) * 255).astype(
    np.uint8
)


def _encoded(light: Float32) -> UInt8:
    """Return sRGB; equal steps of light's root are fine enough in the dark."""
    step = np.sqrt(np.clip(light, 0, 1))
    step *= np.float32(STEPS)
    step += np.float32(0.5)
    return _BYTE_OF_STEP.take(step.astype(np.int32))
