"""The factory calibration of an Azure Kinect, as its recordings carry it: ``calibration.json``.

Cameras ``..._D0`` (depth) and ``..._PV0`` (colour) each have fourteen ``ModelParameters``: cx, cy,
fx, fy as shares of the calibrated image, k1 to k6 and p2, p1 (at 12 and 13) of the rational model,
and ``Rt``, from the rig to the camera in metres. Which part of the calibrated image a mode of the
camera uses is not in the file; the numbers below are those of Microsoft's Azure Kinect Sensor SDK.
"""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.transforms import inverse, rigid_defect
from sceneq_core.ingest.undistortion import Lens

Size = tuple[int, int]

DEPTH_MODES: dict[Size, tuple[Size, Size]] = {
    (640, 576): ((1024, 1024), (192, 180)),
    (320, 288): ((512, 512), (96, 90)),
    (512, 512): ((512, 512), (0, 0)),
    (1024, 1024): ((1024, 1024), (0, 0)),
}
"""Size of the image -> size that the calibration is scaled to, and what is cut off left and top."""
COLOR_MODES: dict[Size, tuple[Size, Size]] = {
    (1280, 720): ((1280, 960), (0, 120)),
    (1920, 1080): ((1920, 1440), (0, 180)),
    (2560, 1440): ((2560, 1920), (0, 240)),
    (2048, 1536): ((2048, 1536), (0, 0)),
    (3840, 2160): ((3840, 2880), (0, 360)),
    (4096, 3072): ((4096, 3072), (0, 0)),
}
DEPTH, COLOR = "CALIBRATION_CameraLocationD0", "CALIBRATION_CameraLocationPV0"


@dataclass(frozen=True, slots=True, eq=False)
class AzureCalibration:
    """Both lenses and T_color_depth (4, 4)."""

    color: Lens
    depth: Lens
    T_color_depth: Float64


def read_calibration(data: bytes, color_size: Size, depth_size: Size) -> AzureCalibration:
    """Return the calibration for images of these sizes; ``ValueError`` names what is wrong."""
    try:
        cameras = json.loads(data)["CalibrationInformation"]["Cameras"]
        by_place = {camera["Location"]: camera for camera in cameras}
        color, depth = by_place[COLOR], by_place[DEPTH]
        T_color_rig, T_depth_rig = _rt(color), _rt(depth)
        lenses = _lens(color, color_size, COLOR_MODES), _lens(depth, depth_size, DEPTH_MODES)
    except (KeyError, TypeError, IndexError) as error:
        raise ValueError(f"calibration.json: no {error}") from error
    except ValueError as error:
        raise ValueError(f"calibration.json: {error}") from error
    return AzureCalibration(*lenses, T_color_rig @ inverse(T_depth_rig))


def _lens(camera: Any, size: Size, modes: dict[Size, tuple[Size, Size]]) -> Lens:
    if size not in modes:
        known = ", ".join(f"{w}x{h}" for w, h in modes)
        raise ValueError(f"images of {size[0]}x{size[1]} are of no mode of the camera ({known})")
    (width, height), (left, top) = modes[size]
    told = np.array(camera["Intrinsics"]["ModelParameters"], np.float64)
    if len(told) < 14 or not np.isfinite(told).all():
        raise ValueError(f"ModelParameters: expected 14 numbers, got {told.tolist()}")
    cx, cy, fx, fy = told[:4]
    K = np.array(
        [
            [fx * width, 0.0, cx * width - left - 0.5],
            [0.0, fy * height, cy * height - top - 0.5],
            [0.0, 0.0, 1.0],
        ]
    )
    k1, k2, k3, k4, k5, k6 = told[4:10]
    p2, p1 = told[12:14]
    return Lens(K, size, "rational_polynomial", np.array([k1, k2, p1, p2, k3, k4, k5, k6]))


def _rt(camera: Any) -> Float64:
    T_camera_rig = np.eye(4)
    T_camera_rig[:3, :3] = np.array(camera["Rt"]["Rotation"], np.float64).reshape(3, 3)
    T_camera_rig[:3, 3] = camera["Rt"]["Translation"]
    if defect := rigid_defect(T_camera_rig):
        raise ValueError(f"Rt: {defect}")
    return T_camera_rig
