"""Frames to bytes and back, beside a copy of the same pixels."""

from collections.abc import Iterator

import numpy as np

from sceneq_core.arrays import Float32, UInt8
from sceneq_core.encoding.dead_leaves import dead_leaves
from sceneq_core.frame import Frame, depth_to_mm
from sceneq_nodes._images import frame_from_message, frame_message
from sceneq_nodes._wire import from_bytes, to_bytes
from sceneq_schemas.topics import FRAME
from sceneq_tools.bench.measurement import Measurement, Options, median, samples_ms

WIDTH_PX, HEIGHT_PX = 640, 480
CODECS = {"raw": ("raw", "raw"), "jpeg + zstd": ("jpeg", "zstd"), "zstd": ("zstd", "zstd")}
"""Of colour and depth: in one machine, between machines, and without loss between machines."""
BESIDE = "copy of its pixels"


def codec(options: Options) -> Iterator[Measurement]:
    """Encode and decode one frame with each pair of image codecs."""
    frame = synthetic_frame()
    # Written pages: those of zeros exist only when they are written to.
    pixels = np.concatenate([frame.rgb.ravel(), depth_to_mm(frame.depth_m).view(np.uint8).ravel()])
    copy_ms = median(samples_ms(pixels.copy, options.seconds))
    megabytes = pixels.nbytes / 1e6
    for name, (rgb, depth) in CODECS.items():
        data = to_bytes(FRAME, frame_message(frame, rgb, depth))

        def encode(rgb: str = rgb, depth: str = depth) -> bytes:
            return to_bytes(FRAME, frame_message(frame, rgb, depth))

        def decode(data: bytes = data) -> Frame:
            return frame_from_message(from_bytes(FRAME, data))

        yield Measurement(f"{name}, size", len(data) / 1e6, "MB", "its pixels", megabytes)
        for verb, work in (("encode", encode), ("decode", decode)):
            taken_ms = median(samples_ms(work, options.seconds))
            rate = megabytes / taken_ms * 1000
            yield Measurement(f"{name}, {verb}", taken_ms, "ms", BESIDE, copy_ms)
            yield Measurement(f"{name}, {verb}", rate, "MB/s", BESIDE, megabytes / copy_ms * 1000)


def synthetic_frame() -> Frame:
    """Return a frame with the statistics of a photograph and a noisy, holed depth."""
    K = np.array([[525.0, 0, 319.5], [0, 525.0, 239.5], [0, 0, 1]])
    rgb = np.ascontiguousarray(dead_leaves(1, WIDTH_PX)[:HEIGHT_PX])
    return Frame(0, 0, rgb, _depth_m(rgb), K, np.eye(4))


def _depth_m(rgb: UInt8) -> Float32:
    """Every leaf is a surface of its own, sloped, with a sensor's noise and a tenth of holes."""
    rng = np.random.default_rng(2)
    surface_m = 1.0 + rgb.mean(axis=2) / 100 + np.linspace(0, 1, HEIGHT_PX)[:, None]
    noisy_m = surface_m + rng.normal(0, 0.002, surface_m.shape) * surface_m**2
    holes = rng.random(surface_m.shape) < 0.1
    return np.where(holes, 0, noisy_m).astype(np.float32)
