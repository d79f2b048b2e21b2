"""Recordings of an Azure Kinect, with the tracks and the attachment that k4arecorder writes."""

import json
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np

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
PINHOLE = [0.5, 0.5, 0.5, 0.5, *[0.0] * 10]


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


def plain(number: int) -> tuple[np.ndarray, np.ndarray]:
    """Return colour and millimetres of a wall whose number can be read off."""
    rgb = np.full((720, 1280, 3), (10 * number, 0, 0), np.uint8)
    return rgb, np.full((288, 320), 1000 + number, np.uint16)


def write_azure(
    av: Any,
    path: Path,
    count: int,
    shown: Callable[[int], tuple[np.ndarray, np.ndarray]] = plain,
    calibration: bool = True,
) -> Path:
    """Write what k4arecorder does: the same tracks by name, raw big-endian depth, an attachment."""
    with av.open(str(path), "w", format="matroska", options={"allow_raw_vfw": "1"}) as file:
        if calibration:
            data = json.dumps(document(PINHOLE, PINHOLE)).encode()
            file.add_attachment("calibration.json", "application/octet-stream", data)
        tracks = {}
        for name, codec, form, size in zip(
            ("COLOR", "DEPTH"), ("mjpeg", "rawvideo"), ("yuvj420p", "gray16be"), SIZES, strict=True
        ):
            tracks[name] = file.add_stream(codec, rate=30)
            tracks[name].width, tracks[name].height = size
            tracks[name].pix_fmt, tracks[name].metadata["title"] = form, name
        for number in range(count):
            rgb, depth_mm = shown(number)
            jpeg = cv2.imencode(".jpg", rgb[..., ::-1])[1].tobytes()
            depth = depth_mm.astype(">u2").tobytes()
            for name, image, late in (("DEPTH", depth, 0), ("COLOR", jpeg, 4)):
                packet = av.Packet(image)
                packet.stream = tracks[name]
                packet.time_base = Fraction(1, 1000)
                packet.pts = packet.dts = 33 * number + late
                packet.is_keyframe = True
                file.mux(packet)
    return path
