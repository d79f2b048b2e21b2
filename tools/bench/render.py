"""Pictures of a furnished room on two cores, beside casting as many rays at a cube."""

import os
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera
from sceneq_tools.bench.measurement import Measurement, Options, median, samples_ms
from sceneq_tools.progress import progress

CORES = 2
"""What the rooms are to be rendered on at five frames a second; others have more."""
KIND, SEED = "living_room", 3
FRAMES = 24
RATE_HZ = 10.0
CAMERA = Camera(np.array([[525.0, 0, 319.5], [0, 525.0, 239.5], [0, 0, 1]]), (640, 480))
BESIDE = "rays at a cube"


def render(options: Options) -> Iterator[Measurement]:
    """Furnish a room, light it and look at it with a camera, from along its path."""
    from sceneq_tools.room.camera.camera_path import camera_path
    from sceneq_tools.room.camera.sensor import measure
    from sceneq_tools.room.layout.compose import compose
    from sceneq_tools.room.light.renderer import Renderer
    from sceneq_tools.room.models.libraries import open_library

    with on_cores(CORES):
        library = open_library()
        what = f"({library.name})"
        with progress("furnishing and lighting a room", None, quiet=options.quiet) as advance:
            room, compose_s = _timed(lambda: compose(KIND, SEED, library))
            advance()
            renderer, light_s = _timed(lambda: Renderer(room))
            advance()
        yield Measurement(f"furnish a room {what}", compose_s, "s")
        yield Measurement(f"light it {what}", light_s, "s")
        poses = camera_path(room, options.frames or FRAMES, RATE_HZ, SEED)
        bare_ms = median(samples_ms(cube_cast(CAMERA), options.seconds))

        def look(pose: Float64) -> object:
            return measure(renderer.render(pose, CAMERA), np.random.default_rng(SEED))

        taken_ms, busy_ms = looks(look, poses, options.quiet)
        per_s = looks_per_s(look, poses)
        yield from frames(f"frame of 640x480 {what}", taken_ms, per_s, bare_ms)
        # Of all threads together: what others do on this machine does not change it.
        yield Measurement(f"frame of 640x480 {what}, processor", median(busy_ms), "ms")


def frames(name: str, taken_ms: list[float], per_s: float, bare_ms: float) -> Iterator[Measurement]:
    """Return the time of one frame after another, and frames a second, ``CORES`` at a time."""
    yield Measurement(name, median(taken_ms), "ms", BESIDE, bare_ms)
    yield Measurement(f"{name}, {CORES} at a time", per_s, "frames/s", BESIDE, 1000 / bare_ms)


@contextmanager
def on_cores(count: int) -> Iterator[None]:
    """Keep this thread, and those it starts, on the first ``count`` cores it may use."""
    usable = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(usable)[:count])
    try:
        yield
    finally:
        os.sched_setaffinity(0, usable)


def cube_cast(camera: Camera) -> Callable[[], Any]:
    """Return what casts a ray through each pixel at a cube, and finds out what it meets."""
    import open3d as o3d

    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(o3d.t.geometry.TriangleMesh.create_box())
    width, height = camera.size
    T_camera_cube = np.eye(4)
    T_camera_cube[:3, 3] = -0.5, -0.5, 1.5  # the cube lies between 0 and 1, before the camera
    tensor = o3d.core.Tensor.from_numpy
    rays = scene.create_rays_pinhole(tensor(camera.K), tensor(T_camera_cube), width, height)
    return lambda: scene.cast_rays(rays)


def looks(
    look: Callable[[Float64], Any], poses: list[Float64], quiet: bool
) -> tuple[list[float], list[float]]:
    """Return time and processor time of a look from each pose, ms; from the first twice."""
    look(poses[0])
    taken_ms, busy_ms = [], []
    with progress("frames", len(poses), quiet=quiet) as advance:
        for pose in poses:
            before_s = time.process_time()
            _, taken_s = _timed(partial(look, pose))
            busy_ms.append(1000 * (time.process_time() - before_s))
            taken_ms.append(1000 * taken_s)
            advance()
    return taken_ms, busy_ms


def looks_per_s(look: Callable[[Float64], Any], poses: list[Float64]) -> float:
    """Return how many looks are done in a second, ``CORES`` at a time, as a recording is made."""
    import cv2

    cv2.setNumThreads(1)  # as when a recording is made
    with ThreadPoolExecutor(CORES) as pool:
        _, taken_s = _timed(lambda: list(pool.map(look, poses)))
    return len(poses) / taken_s


def _timed(work: Callable[[], Any]) -> tuple[Any, float]:
    start_s = time.perf_counter()
    done = work()
    return done, time.perf_counter() - start_s
