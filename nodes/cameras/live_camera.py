"""What all cameras on this machine have in common: opened when ingest starts, lost, found again."""

import importlib
import logging
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from sceneq_core.arrays import Float64, UInt8, UInt16
from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped, Waiting
from sceneq_nodes._bus import Bus

log = logging.getLogger(__name__)

RETRY_S, SILENT_S = 2.0, 5.0
DAY_S, SEQ_HZ = 86_400, 100
"""Numbers grow faster than any camera: a source that starts again the same day reuses none."""


@dataclass(frozen=True, slots=True)
class CameraParams:
    """``width``, ``height`` and ``fps`` of colour as asked of the camera; depth is aligned to it.

    ``serial`` of one camera of many; empty = the first.
    """

    width: int = 640
    height: int = 480
    fps: int = 30
    serial: str = ""

    def __post_init__(self) -> None:
        for name in ("width", "height", "fps"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name}: expected 1 or more, got {getattr(self, name)}")


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """One instant: RGB (H, W, 3), millimetres (h, w), and the camera's pose if it knows it."""

    stamp_ns: int
    rgb: UInt8
    depth_mm: UInt16
    T_world_camera: Float64 | None = None


class Device(Protocol):
    """An opened camera. All methods raise ``LostError`` when it is gone."""

    color_camera: Camera
    depth_camera: Camera

    def take(self) -> Shot | None:
        """Return the newest shot not taken yet, ``None`` when there is none."""

    def close(self) -> None:
        """Give the camera back."""


class LostError(Exception):
    """A camera that was there does not answer any more."""


class LiveCamera:
    """Frames of a camera as they come, ``Waiting`` in between; what comes too fast is left out.

    ``open_device`` raises ``ValueError`` with what to install or to plug in.
    """

    def __init__(
        self,
        name: str,
        open_device: Callable[[], Device],
        has_poses: bool = False,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.name = name
        self.has_poses = has_poses
        self.T_color_depth = np.eye(4)
        self._open = open_device
        self._clock = clock
        self._device: Device | None = None
        self._bus: Bus | None = None
        self._seq = int(time.time() % DAY_S * SEQ_HZ)
        self._last_ns = -1
        self._trouble = ""

    def connect(self, bus: Bus) -> None:
        """Open the camera; raise ``ValueError`` when it cannot be had."""
        self._bus = bus
        self._device = self._open()
        self.color_camera = self._device.color_camera
        self.depth_camera = self._device.depth_camera
        self._heard_s = self._retry_s = self._clock()

    def frames(self) -> Iterator[RawFrame | Skipped | Waiting]:
        """Yield what has come; goes on where it was."""
        while True:
            shot = self._shot()
            yield Waiting() if shot is None else self._frame(shot)

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """Refuse: the room is a real one."""
        raise RefusedError("a camera's room cannot be changed", "a simulation can: sceneq up --sim")

    def close(self) -> None:
        """Give the camera back."""
        device, self._device = self._device, None
        try:
            if device is not None:
                device.close()
        except LostError as error:
            log.info("%s: %s", self.name, error)

    def _shot(self) -> Shot | None:
        try:
            shot = self._found().take()
        except (LostError, ValueError) as error:
            self._lose(str(error))
            return None
        now_s = self._clock()
        if shot is None or shot.stamp_ns <= self._last_ns:
            if now_s - self._heard_s > SILENT_S:
                self._say(f"{self.name}: no image for {SILENT_S:g} s")
            return None
        self._heard_s, self._last_ns = now_s, shot.stamp_ns
        self._say("")
        return shot

    def _found(self) -> Device:
        """Return the device, opened again when it was lost and it is time to try."""
        if self._device is None:
            if self._clock() < self._retry_s:
                raise LostError(self._trouble)
            self._device = self._open()
            self._count("camera_found")
            if not _is_same(self._device.color_camera, self.color_camera):
                raise LostError("it came back with another resolution or calibration")
        return self._device

    def _lose(self, reason: str) -> None:
        now_s = self._clock()
        if self._device is not None:
            self._count("camera_lost")
            self.close()
        if now_s >= self._retry_s:
            self._retry_s = now_s + RETRY_S
        self._say(reason)

    def _frame(self, shot: Shot) -> RawFrame:
        self._seq += 1
        return RawFrame(
            seq=self._seq,
            stamp_ns=shot.stamp_ns,
            T_world_camera=shot.T_world_camera,
            read_rgb=lambda: shot.rgb,
            read_depth_mm=lambda: shot.depth_mm,
        )

    def _say(self, trouble: str) -> None:
        if trouble != self._trouble:
            log.warning("%s", trouble or f"{self.name}: images come again")
            self._trouble = trouble
            if self._bus is not None:
                self._bus.report(trouble=trouble)

    def _count(self, name: str) -> None:
        if self._bus is not None:
            self._bus.count(name)


def need(module: str, package: str, extra: str) -> Any:
    """Return the maker's module; ``ValueError`` says in a line what to install."""
    try:
        return importlib.import_module(module)
    except ImportError as error:
        hint = f"pip install 'sceneq[{extra}]'"
        raise ValueError(f"{package} cannot be imported ({error}); {hint}") from error


def camera_of(fx: float, fy: float, cx: float, cy: float, size: tuple[int, int]) -> Camera:
    """Return a pinhole camera; ``ValueError`` when these are no intrinsics."""
    K = np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]])
    if not (np.isfinite(K).all() and fx > 0 and fy > 0 and min(size) > 0):
        raise ValueError(f"the camera tells no intrinsics: {K.tolist()}, {size}")
    return Camera(K, size)


def in_mm(depth: Any, mm_per_unit: float) -> UInt16:
    """Return whole millimetres; what is not finite or beyond 16 bits is no measurement."""
    if mm_per_unit == 1.0 and depth.dtype == np.uint16:
        return np.array(depth)
    with np.errstate(invalid="ignore"):
        depth_mm = np.rint(np.asarray(depth, np.float32) * np.float32(mm_per_unit))
        held = (depth_mm > 0) & (depth_mm < np.iinfo(np.uint16).max)
    return np.where(held, depth_mm, 0).astype(np.uint16)


def _is_same(one: Camera, other: Camera) -> bool:
    return one.size == other.size and np.array_equal(one.K, other.K)
