"""Azure Kinect recordings: the calibration, and .mkv files with the same tracks and attachment."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.ingest.source import RawFrame, Skipped
from sceneq_nodes._backends import build
from sceneq_nodes._source_kinds import kind_of
from sceneq_nodes.datasets.azure_calibration import read_calibration

from support.azure_files import SIZES, document, write_azure


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


def test_frames_of_a_recording(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    path = write_azure(av, tmp_path / "office.mkv", 5)
    assert kind_of(path) == "azure"
    source = build("source", {"kind": "azure", "path": str(path), "color_side_px": 640})
    assert source.color_camera.size == (640, 360)
    assert source.depth_camera.size == (320, 288)
    np.testing.assert_allclose(source.T_color_depth[0, 3], -0.032)
    frames = list(source.frames())
    assert len(frames) == 5
    for number, frame in enumerate(frames):
        assert isinstance(frame, RawFrame)
        assert (frame.seq, frame.stamp_ns) == (number, 33_000_000 * number + 4_000_000)
        assert float(frame.read_rgb()[..., 0].mean()) == pytest.approx(10 * number, abs=3)
        assert int(frame.read_depth_mm()[144, 160]) == 1000 + number
    damaged = source._depth_mm(3, b"12")
    assert isinstance(damaged, Skipped)
    assert isinstance(source._rgb(3, b"12"), Skipped)


def test_a_film_of_another_camera_is_refused(tmp_path: Path) -> None:
    av = pytest.importorskip("av")
    path = write_azure(av, tmp_path / "office.mkv", 1, calibration=False)
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
