"""RealSense, OAK, Orbbec and Record3D cameras, on fakes of their packages."""

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.ingest.source import RawFrame, RefusedError, Waiting
from sceneq_nodes._backends import build
from sceneq_nodes.cameras import live_camera

from support import fake_cameras as fake
from support.data_sets import units
from support.fake_bus import FakeBus
from support.realsense_recording import record_realsense
from support.seven_scenes import SIZE, K, color

MAKE: dict[str, tuple[str, Callable]] = {
    "realsense": ("pyrealsense2", fake.realsense),
    "oak": ("depthai", fake.depthai),
    "orbbec": ("pyorbbecsdk", fake.orbbec),
    "record3d": ("record3d", fake.record3d),
}
SIZED = {"width": SIZE[0], "height": SIZE[1]}


class Camera:
    """A source on a fake, with a clock that the test moves."""

    def __init__(self, kind: str, monkeypatch: pytest.MonkeyPatch, **options) -> None:
        self.wall, self.now_s, self.bus = fake.Wall(), 100.0, FakeBus()
        module, make = MAKE[kind]
        monkeypatch.setitem(sys.modules, module, make(self.wall, **options))
        self.source = build("source", {"kind": kind, **({} if kind == "record3d" else SIZED)})
        self.source._clock = lambda: self.now_s
        self.source.connect(self.bus)
        self.frames = self.source.frames()

    def next(self) -> RawFrame | Waiting:
        self.now_s += 0.033
        return next(self.frames)


@pytest.mark.parametrize("kind", sorted(MAKE))
def test_frames_are_what_the_camera_shows(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Camera(kind, monkeypatch)
    np.testing.assert_array_equal(camera.source.color_camera.K, K)
    assert camera.source.color_camera.size == camera.source.depth_camera.size == SIZE
    found = []
    for _ in range(3):
        found.append(camera.next())
        if kind == "record3d" and len(found) < 3:
            camera.wall.stream.send()
    assert isinstance(camera.next(), Waiting)
    for number, frame in enumerate(found):
        assert isinstance(frame, RawFrame)
        np.testing.assert_array_equal(frame.read_rgb(), color(number))
        expected = units(number, 1000)
        if kind == "record3d":
            expected[-1] = expected[0, 2] = 0
        np.testing.assert_array_equal(frame.read_depth_mm(), expected)
        assert (frame.T_world_camera is not None) == camera.source.has_poses
    assert (np.diff([f.seq for f in found]) == 1).all()
    assert (np.diff([f.stamp_ns for f in found]) > 0).all()


@pytest.mark.parametrize("kind", sorted(MAKE))
def test_an_absent_package_is_said_with_what_to_install(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, MAKE[kind][0], None)
    source = build("source", {"kind": kind})
    with pytest.raises(ValueError, match=r"pip install 'sceneq\[") as caught:
        source.connect(FakeBus())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", sorted(MAKE))
def test_an_absent_camera_is_said_with_what_to_do(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    wall = fake.Wall()
    wall.is_there = False
    monkeypatch.setitem(sys.modules, MAKE[kind][0], MAKE[kind][1](wall))
    with pytest.raises(ValueError, match=rf"^{kind}: (No device|0 phones).*\(") as caught:
        build("source", {"kind": kind}).connect(FakeBus())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["realsense", "oak", "orbbec"])
def test_a_camera_that_is_lost_is_looked_for_again(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    camera = Camera(kind, monkeypatch)
    assert isinstance(camera.next(), RawFrame)
    camera.wall.is_there = False
    for _ in range(200):
        assert isinstance(camera.next(), Waiting)
    assert camera.bus.counters == {"camera_lost": 1}
    assert str(camera.bus.reported["trouble"]).startswith(f"{kind}: No device connected")
    assert camera.wall.closed == 1
    camera.wall.is_there = True
    camera.now_s += live_camera.RETRY_S
    assert isinstance(camera.next(), RawFrame)
    assert camera.bus.counters == {"camera_lost": 1, "camera_found": 1}
    assert camera.bus.reported["trouble"] == ""
    assert camera.wall.opened == 2


def test_silence_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Camera("oak", monkeypatch)
    camera.wall.left = 0
    camera.next()
    assert "trouble" not in camera.bus.reported
    camera.now_s += live_camera.SILENT_S
    camera.next()
    assert camera.bus.reported["trouble"] == "oak: no image for 5 s"


def test_halves_of_a_pair_are_not_mixed(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Camera("realsense", monkeypatch, late_ms=33.0)
    assert isinstance(camera.next(), Waiting)


@pytest.mark.parametrize(
    ("kind", "options"), [("realsense", {"coeffs": (0.3, 0, 0, 0, 0)}), ("orbbec", {"k1": 0.3})]
)
def test_a_lens_is_undone(kind: str, options: dict, monkeypatch: pytest.MonkeyPatch) -> None:
    frame = Camera(kind, monkeypatch, **options).next()
    assert frame.read_rgb()[24, 32].tolist() == color(0)[24, 32].tolist()
    assert (frame.read_rgb()[0, 0] == 0).all()
    assert frame.read_depth_mm()[0, 0] == 0


def test_a_mirror_of_a_phone_is_mirrored_back(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = Camera("record3d", monkeypatch, device_type=0).next()
    assert int(frame.read_depth_mm()[5, SIZE[0] - 1 - 5]) == 2000


def test_a_phone_that_stops_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Camera("record3d", monkeypatch)
    assert isinstance(camera.next(), RawFrame)
    camera.wall.stream.on_stream_stopped()
    camera.wall.is_there = False
    assert isinstance(camera.next(), Waiting)
    assert camera.bus.counters == {"camera_lost": 1}


def test_a_room_cannot_be_changed(monkeypatch: pytest.MonkeyPatch) -> None:
    camera = Camera("oak", monkeypatch)
    with pytest.raises(RefusedError, match="cannot be changed"):
        camera.source.control("move", {})
    camera.source.close()
    assert camera.wall.closed == 1


@pytest.mark.parametrize(
    ("kind", "params", "said"),
    [
        ("oak", {"fps": 0}, "fps"),
        ("realsense", {"width": 0}, "width"),
        ("realsense", {"lossless": True}, "lossless"),
        ("record3d", {"device": -1}, "device"),
        ("record3d", {"min_confidence": 3}, "min_confidence"),
    ],
)
def test_bad_parameters_are_named(kind: str, params: dict, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        build("source", {"kind": kind, **params})


@pytest.mark.parametrize(("lossless", "least"), [(False, 1), (True, 6)])
def test_what_librealsense_recorded_is_played_by_it(
    lossless: bool, least: int, tmp_path: Path
) -> None:
    rs = pytest.importorskip("pyrealsense2")
    path = tmp_path / "wall.db3"
    record_realsense(rs, path, 6)
    spec = {"kind": "realsense", "playback": str(path), "lossless": lossless}
    source = build("source", spec)
    source.connect(FakeBus())
    np.testing.assert_allclose(source.color_camera.K, K)
    found, frames, deadline_s = [], source.frames(), time.monotonic() + 60.0
    while len(found) < least and time.monotonic() < deadline_s:
        if isinstance(frame := next(frames), RawFrame):
            found.append(frame)
    source.close()
    assert len(found) == least
    for frame in found:
        number = int(frame.read_rgb()[0, 0, 0])
        depth, expected = frame.read_depth_mm(), units(number, 1000)
        held = (depth > 0) & (expected > 0)  # aligning leaves holes, even to itself, and fills some
        assert held.mean() > 0.9
        np.testing.assert_array_equal(depth[held], expected[held])
