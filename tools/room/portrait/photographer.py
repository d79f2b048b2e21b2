"""Takes portraits: from where a robot or a person might stand, with any camera."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float64, UInt8
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.camera.colour_sensor import ColourSensor
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.light.renderer import Renderer
from sceneq_tools.room.portrait.stage import Posed
from sceneq_tools.room.rendering import Rendering
from sceneq_tools.room.room import Room

SIZE = (240, 200)
FOCAL_PX = 0.82 * SIZE[0]
CAMERA = Camera(
    np.array([[FOCAL_PX, 0, (SIZE[0] - 1) / 2], [0, FOCAL_PX, (SIZE[1] - 1) / 2], [0, 0, 1.0]]),
    SIZE,
)
QUICK = Quality(
    shadow_rays=4, gather_rays=12, bounces=2, cell_m=0.12, texture_px=512, edge_rays=1, threads=1
)
TRIES = 3
"""More than portraits wanted: a thing may be hidden, or in the dark."""
LEAST_PX, LEAST_SHRUNK_PX = 300, 250
DARKEST = 18.0
SHRINKS = (1.0, 0.6, 0.35)
SHRINK_SHARES = (0.55, 0.3, 0.15)


@dataclass(frozen=True, slots=True, eq=False)
class Portrait:
    """``jpeg`` of a picture, ``mask`` bool (h, w) of the thing in it."""

    posed: Posed
    jpeg: bytes
    mask: Bool


def portraits(
    room: Room, posed: tuple[Posed, ...], views: int, rng: np.random.Generator
) -> Iterator[Portrait]:
    """Yield up to so many ``views`` of everything that is posed."""
    renderer = Renderer(room, QUICK)
    for one in posed:
        taken = 0
        for _ in range(views + TRIES):
            if taken < views and (shot := _shot(renderer, one, rng)) is not None:
                taken += 1
                yield shot


def _shot(renderer: Renderer, posed: Posed, rng: np.random.Generator) -> Portrait | None:
    T_world_camera = _stand(renderer.room, posed, rng)
    if T_world_camera is None:
        return None
    rendering = renderer.render(T_world_camera, CAMERA)
    mask = rendering.instance_id == posed.id
    if mask.sum() < LEAST_PX:
        return None
    rgb = _developed(rendering, rng)
    if rgb[mask].mean() < DARKEST:
        return None
    shrink = float(rng.choice(SHRINKS, p=SHRINK_SHARES))
    if shrink < 1 and mask.sum() * shrink * shrink > LEAST_SHRUNK_PX:
        rgb = np.asarray(
            cv2.resize(rgb, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA), np.uint8
        )
        size = (rgb.shape[1], rgb.shape[0])
        mask = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    quality = int(rng.uniform(60, 95))
    _, jpeg = cv2.imencode(".jpg", rgb[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    return Portrait(posed, jpeg.tobytes(), mask)


def _developed(rendering: Rendering, rng: np.random.Generator) -> UInt8:
    """Return what a camera of any exposure, sharpness and noise makes of it."""
    exposure = rng.uniform(0.85, 1.5)
    toned = np.clip(255 * (rendering.rgb / 255.0) ** (1 / exposure), 0, 255).astype(np.uint8)
    sensor = ColourSensor(blur_px=rng.uniform(0.2, 1.2), photons=10 ** rng.uniform(3.3, 4.3))
    return sensor.measure(replace(rendering, rgb=toned), rng)


def _stand(room: Room, posed: Posed, rng: np.random.Generator) -> Float64 | None:
    """Return a pose (4, 4) in front of the thing, ``None`` when that is too close."""
    centre, size = posed.centre, posed.size
    far, near = rng.uniform(0.25, 0.9), rng.uniform(0.9, 1.6)
    fill = rng.choice([far, near], p=[0.75, 0.25])
    extent = max(math.hypot(size[0], size[1]) * 0.9, size[2] * 1.1, 0.05)
    distance = max(0.45, extent * FOCAL_PX / (fill * SIZE[1]))
    angle = np.clip(rng.normal(0, 0.6), -1.3, 1.3)
    eye_m = rng.uniform(1.0, 1.8) if rng.random() < 0.8 else rng.uniform(0.3, 2.2)
    level = math.sqrt(max(distance**2 - (eye_m - centre[2]) ** 2, (0.35 * distance) ** 2))
    behind = [centre[0] + level * math.sin(angle), centre[1] - level * math.cos(angle), eye_m]
    eye = np.clip(behind, 0.05, np.array(room.size_m) - 0.05)
    if np.linalg.norm(eye - centre) < 0.3:
        return None
    return _looking(eye, centre + rng.normal(0, 0.08, 3) * size)


def _looking(eye: Float64, at: Float64) -> Float64:
    """Return the upright pose (4, 4) that looks from ``eye`` at a point."""
    ahead = (at - eye) / np.linalg.norm(at - eye)
    right = np.cross(ahead, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    T_world_camera = np.eye(4)
    T_world_camera[:3, :3] = np.stack([right, np.cross(ahead, right), ahead], axis=1)
    T_world_camera[:3, 3] = eye
    return T_world_camera
