"""Azure Kinect recordings: the calibration, and .mkv files with the same tracks and attachment."""

import json
import sys
from fractions import Fraction
from pathlib import Path

import cv2
import numpy as np
import pytest

from sceneq_core.ingest.source import RawFrame, Skipped
from sceneq_nodes._backends import build
from sceneq_nodes._source_kinds import kind_of
from sceneq_nodes.datasets.azure_calibration import read_calibration

DEPTH = [0.5122697949409485, 0.49451231956481934, 0.4921168386936188, 0.4921667277812958,
         3.1305770874023438, 2.324939012527466, 0.1304156482219696, 3.458651542663574,
         3.350114583969116, 0.6629416346549988, 0, 0, -0.0000511557373101823,
         0.00008132171933539212]  # fmt: skip
COLOR = [0.4967627227306366, 0.5108628273010254, 0.470907062292099, 0.6274453997612,
         0.7227460145950317, -2.8855903148651123, 1.6327226161956787, 0.6021990180015564,
         -2.7196261882781982, 1.565053105354309, 0, 0, -0.0001431911950930953,
         0.0007828465895727277]  # fmt: skip
"""What a real camera has; its SDK said the numbers of ``test_modes`` for 1080p and NFOV."""
SIZES = (1280, 720), (320, 288)


def document(depth: list = DEPTH, color: list = COLOR) -> dict:
    def camera(place: str, told: list, shift: list) -> dict:
        turn = np.eye(3).ravel().tolist()
        return {
            "Location": f"CALIBRATION_CameraLocation{place}",
            "Intrinsics": {"ModelParameterCount": 14, "ModelParameters": told},
            "Rt": {"Rotation": turn, "Translation": shift},
        }

    cameras = [camera("D0", depth, [0, 0, 0]), camera("PV0", color, [-0.032, -0.002, 0.004])]
    return {"CalibrationInformation": {"Cameras": cameras}}


def test_modes_are_those_of_the_sdk() -> None:
    found = read_calibration(json.dumps(document()).encode(), (1920, 1080), (640, 576))
    K, d = found.depth.K, found.depth.coefficients
    told = [K[0, 0], K[1, 1], K[0, 2], K[1, 2]]
    np.testing.assert_allclose(told, [503.927643, 503.978729, 332.064270, 325.880615], atol=1e-3)
    expected = [3.130577, 2.324939, 0.000081, -0.000051, 0.130416, 3.458652, 3.350115, 0.662942]
    np.testing.assert_allclose(d, expected, atol=1e-6)
    K = found.color.K
    told = [K[0, 0], K[1, 1], K[0, 2], K[1, 2]]
    np.testing.assert_allclose(told, [904.141541, 903.521362, 953.284424, 555.142456], atol=1e-3)
    np.testing.assert_allclose(found.T_color_depth[:3, 3], [-0.032, -0.002, 0.004])


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"{", "calibration.json: Expecting"),
        (b"{}", "no 'CalibrationInformation'"),
        (json.dumps(document(depth=[1.0])).encode(), "expected 14 numbers"),
    ],
)
def test_a_bad_calibration_is_named(data: bytes, said: str) -> None:
    with pytest.raises(ValueError, match=said):
        read_calibration(data, *SIZES)
    with pytest.raises(ValueError, match="33x44 are of no mode"):
        read_calibration(json.dumps(document()).encode(), (33, 44), SIZES[1])


def write(av, path: Path, count: int, calibration: bool = True) -> Path:
    """Write what k4arecorder does: the same tracks by name, raw big-endian depth, an attachment."""
    pinhole = [0.5, 0.5, 0.5, 0.5, *[0.0] * 10]
    with av.open(str(path), "w", format="matroska", options={"allow_raw_vfw": "1"}) as file:
        if calibration:
            data = json.dumps(document(pinhole, pinhole)).encode()
            file.add_attachment("calibration.json", "application/octet-stream", data)
        tracks = {}
        for name, codec, form, size in zip(
            ("COLOR", "DEPTH"), ("mjpeg", "rawvideo"), ("yuvj420p", "gray16be"), SIZES, strict=True
        ):
            tracks[name] = file.add_stream(codec, rate=30)
            tracks[name].width, tracks[name].height = size
            tracks[name].pix_fmt, tracks[name].metadata["title"] = form, name
        for number in range(count):
            rgb = np.full((720, 1280, 3), (0, 0, 10 * number), np.uint8)
            depth = np.full((288, 320), 1000 + number, ">u2")
            jpeg = cv2.imencode(".jpg", rgb)[1].tobytes()
            for name, image, late in (("COLOR", jpeg, 0), ("DEPTH", depth.tobytes(), 4)):
                packet = av.Packet(image)
                packet.stream = tracks[name]
                packet.time_base = Fraction(1, 1000)
                packet.pts = packet.dts = 33 * number + late
                packet.is_keyframe = True
                file.mux(packet)
    return path


def test_frames_of_a_recording(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    path = write(av, tmp_path / "office.mkv", 5)
    assert kind_of(path) == "azure"
    source = build("source", {"kind": "azure", "path": str(path), "color_side_px": 640})
    assert source.color_camera.size == (640, 360)
    assert source.depth_camera.size == (320, 288)
    np.testing.assert_allclose(source.T_color_depth[0, 3], -0.032)
    frames = list(source.frames())
    assert len(frames) >= 4
    for number, frame in enumerate(frames):
        assert isinstance(frame, RawFrame)
        assert (frame.seq, frame.stamp_ns) == (number, 33_000_000 * number)
        assert float(frame.read_rgb()[..., 0].mean()) == pytest.approx(10 * number, abs=3)
        assert int(frame.read_depth_mm()[144, 160]) == 1000 + number
    damaged = source._depth_mm(3, b"12")
    assert isinstance(damaged, Skipped)
    assert isinstance(source._rgb(3, b"12"), Skipped)


def test_a_film_of_another_camera_is_refused(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    path = write(av, tmp_path / "office.mkv", 1, calibration=False)
    with pytest.raises(ValueError, match=r"no attachment calibration\.json"):
        build("source", {"kind": "azure", "path": str(path)})
    (tmp_path / "rubbish.mkv").write_bytes(b"\x1aE\xdf\xa3 rubbish")
    with pytest.raises(ValueError, match=r"rubbish\.mkv: cannot be read"):
        build("source", {"kind": "azure", "path": str(tmp_path / "rubbish.mkv")})


def test_without_its_package_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ValueError, match=r"pip install 'sceneq\[azure\]'"):
        build("source", {"kind": "azure", "path": str(tmp_path / "a.mkv")})
