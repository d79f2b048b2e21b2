"""Thin fakes of the makers' packages: what our sources call, as their documentation has it."""

from datetime import timedelta
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np

from support.data_sets import units
from support.more_data_sets import arkit_pose
from support.seven_scenes import SIZE, K, color

STAMP_MS = 33.0


def pinhole(*names: str) -> dict[str, float]:
    """Return focal lengths and centre of the camera under the names of a maker."""
    return dict(zip(names, (K[0, 0], K[1, 1], K[0, 2], K[1, 2]), strict=True))


class GoneError(RuntimeError):
    """What a library raises when the cable is out."""


class Wall:
    """The wall of ``seven_scenes`` as a camera would show it; ``left`` images, then nothing."""

    def __init__(self, left: int = 3) -> None:
        self.left, self.number, self.is_there, self.opened, self.closed = left, -1, True, 0, 0

    def open(self) -> None:
        if not self.is_there:
            raise GoneError("No device connected")
        self.opened += 1

    def next(self) -> int | None:
        if not self.is_there:
            raise GoneError("device disconnected")
        if self.number + 1 >= self.left:
            return None
        self.number += 1
        return self.number

    def stop(self, *_: Any) -> None:
        self.closed += 1


def realsense(
    wall: Wall, coeffs: tuple[float, ...] = (0.0,) * 5, late_ms: float = 0.0
) -> ModuleType:
    """Return ``pyrealsense2`` with one camera."""
    told = SimpleNamespace(
        width=SIZE[0], height=SIZE[1], **pinhole("fx", "fy", "ppx", "ppy"),
        model="brown_conrady", coeffs=list(coeffs),
    )  # fmt: skip

    class Picture:
        def __init__(self, data: np.ndarray, at_ms: float) -> None:
            self.get_data, self.get_timestamp = (lambda: data), (lambda: at_ms)

    class Pipeline:
        def start(self, config: Any) -> Any:
            wall.open()
            stream = SimpleNamespace(get_intrinsics=lambda: told)
            sensor = SimpleNamespace(get_depth_scale=lambda: 0.0010000000474974513)
            device = SimpleNamespace(first_depth_sensor=lambda: sensor)
            profile = SimpleNamespace(as_video_stream_profile=lambda: stream)
            return SimpleNamespace(get_device=lambda: device, get_stream=lambda _: profile)

        def try_wait_for_frames(self, wait_ms: int) -> tuple[bool, Any]:
            number = wall.next()
            return number is not None, number

        stop = staticmethod(wall.stop)

    class Align:
        def __init__(self, stream: Any) -> None:
            assert stream == "color"

        def process(self, number: int) -> Any:
            at_ms = STAMP_MS * (number + 1)
            return SimpleNamespace(
                get_color_frame=lambda: Picture(color(number), at_ms),
                get_depth_frame=lambda: Picture(units(number, 1000), at_ms + late_ms),
            )

    return _module(
        "pyrealsense2", pipeline=Pipeline, align=Align, config=_Anything,
        stream=SimpleNamespace(color="color", depth="depth"),
        format=SimpleNamespace(rgb8="rgb8", z16="z16"),
        distortion=SimpleNamespace(
            brown_conrady="brown_conrady", modified_brown_conrady="modified_brown_conrady"
        ),
    )  # fmt: skip


def depthai(wall: Wall) -> ModuleType:
    """Return ``depthai`` 3 with one OAK-D."""

    class Image:
        def __init__(self, number: int) -> None:
            at = timedelta(milliseconds=STAMP_MS * (number + 1))
            self.getCvFrame = lambda: color(number)[..., ::-1]
            self.getFrame = lambda: units(number, 1000)
            self.getTimestamp = lambda: at

    class Queue:
        def tryGet(self) -> Any:  # noqa: N802
            number = wall.next()
            return None if number is None else {"color": Image(number), "depth": Image(number)}

    class Pipeline(_Anything):
        def create(self, kind: Any) -> Any:
            node = _Anything()
            node.out = SimpleNamespace(createOutputQueue=lambda **_: Queue())
            node.inputs = {"color": _Anything(), "depth": _Anything()}
            return node

        stop = staticmethod(wall.stop)

    class Device:
        def __init__(self, *_: Any) -> None:
            wall.open()

        def readCalibration(self) -> Any:  # noqa: N802
            return SimpleNamespace(getCameraIntrinsics=lambda socket, w, h: K.tolist())

    return _module(
        "depthai", Device=Device, DeviceInfo=str, Pipeline=Pipeline,
        CameraBoardSocket=SimpleNamespace(CAM_A=0, CAM_B=1, CAM_C=2),
        ImgFrame=SimpleNamespace(Type=SimpleNamespace(BGR888i=0)),
        node=SimpleNamespace(Camera="Camera", StereoDepth="StereoDepth", Sync="Sync"),
    )  # fmt: skip


def orbbec(wall: Wall, k1: float = 0.0) -> ModuleType:
    """Return ``pyorbbecsdk`` with one camera; a unit of its depth is a tenth of a millimetre."""

    class Picture:
        def __init__(self, data: np.ndarray, number: int) -> None:
            self.get_data = lambda: data.tobytes()
            self.get_height, self.get_width = (lambda: SIZE[1]), (lambda: SIZE[0])
            self.get_format, self.get_depth_scale = (lambda: "RGB"), (lambda: 0.1)
            self.get_timestamp_us = lambda: 33000 * (number + 1)

    class Frames:
        def __init__(self, number: int) -> None:
            self.get_color_frame = lambda: Picture(color(number), number)
            self.get_depth_frame = lambda: Picture(10 * units(number, 1000), number)
            self.as_frame_set = lambda: self

    class Pipeline(_Anything):
        def start(self, config: Any) -> None:
            wall.open()

        def get_camera_param(self) -> Any:
            straight = SimpleNamespace(
                **pinhole("fx", "fy", "cx", "cy"), width=SIZE[0], height=SIZE[1]
            )
            names = ("k2", "k3", "k4", "k5", "k6", "p1", "p2")
            bent = SimpleNamespace(k1=k1, **dict.fromkeys(names, 0.0))
            return SimpleNamespace(rgb_intrinsic=straight, rgb_distortion=bent)

        def wait_for_frames(self, wait_ms: int) -> Any:
            number = wall.next()
            return None if number is None else Frames(number)

        stop = staticmethod(wall.stop)

    class Align:
        def __init__(self, align_to_stream: Any) -> None:
            self.process = lambda frames: frames

    return _module(
        "pyorbbecsdk", Pipeline=Pipeline, Config=_Anything, AlignFilter=Align, Context=_Anything,
        OBSensorType=SimpleNamespace(COLOR_SENSOR=0, DEPTH_SENSOR=1),
        OBFormat=SimpleNamespace(RGB="RGB", MJPG="MJPG"),
        OBStreamType=SimpleNamespace(COLOR_STREAM=0),
    )  # fmt: skip


def record3d(wall: Wall, device_type: int = 1) -> ModuleType:
    """Return ``record3d`` with one phone that sends as soon as it is connected."""

    class Stream:
        @staticmethod
        def get_connected_devices() -> list[Any]:
            return ["phone"] if wall.is_there else []

        def connect(self, phone: Any) -> None:
            wall.open()
            wall.stream = self
            self.send()

        def send(self) -> None:
            number = wall.next()
            if number is None:
                return
            rgb, depth = color(number), (units(number, 1000) / 1000).astype(np.float32)
            depth[0, 2] = np.nan
            self.get_rgb_frame, self.get_depth_frame = (lambda: rgb), (lambda: depth)
            confidence = np.full(depth.shape, 2, np.uint8)
            confidence[-1] = 0
            self.get_confidence_frame = lambda: confidence
            told = SimpleNamespace(**pinhole("fx", "fy", "tx", "ty"))
            self.get_intrinsic_mat = lambda: told
            names = ("qx", "qy", "qz", "qw", "tx", "ty", "tz")
            pose = SimpleNamespace(**dict(zip(names, arkit_pose(number), strict=True)))
            self.get_camera_pose, self.get_device_type = (lambda: pose), (lambda: device_type)
            self.on_new_frame()

        disconnect = staticmethod(wall.stop)

    return _module("record3d", Record3DStream=Stream)


class _Anything:
    """Whatever is called on it goes well and says nothing."""

    def __init__(self, *_: Any, **__: Any) -> None:
        pass

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return _Anything()

    def __call__(self, *_: Any, **__: Any) -> "_Anything":
        return _Anything()


def _module(name: str, **values: Any) -> ModuleType:
    module = ModuleType(name)
    vars(module).update(values)
    return module
