"""The sample that comes with Scene-Q, made small: processes are to be harmed, not kept busy."""

from importlib.resources import files
from pathlib import Path

import cv2
import numpy as np

SCALE = 0.5
FRAMES = 12
LAST = 45


def write_small_sample(folder: Path, frames: int = FRAMES) -> Path:
    """Write the first ``frames`` of the sample, at most 45, at half its size; return ``folder``."""
    sample = Path(str(files("sceneq_tools"))) / "sample"
    folder.mkdir(parents=True)
    K = np.loadtxt(sample / "camera-intrinsics.txt")
    K[:2, 2] = (K[:2, 2] + 0.5) * SCALE - 0.5
    K[0, 0], K[1, 1] = K[0, 0] * SCALE, K[1, 1] * SCALE
    np.savetxt(folder / "camera-intrinsics.txt", K)
    for number in range(min(frames, LAST)):
        _write_frame(sample, folder, f"frame-{number:06d}")
    return folder


def _write_frame(sample: Path, folder: Path, stem: str) -> None:
    for name, shrink in (
        ("color.jpg", cv2.INTER_AREA),
        ("depth.png", cv2.INTER_NEAREST),
        ("mask.png", cv2.INTER_NEAREST),
    ):
        image = cv2.imread(str(sample / f"{stem}.{name}"), cv2.IMREAD_UNCHANGED)
        if image is None:
            raise ValueError(f"{sample}: no {stem}.{name}")
        small = cv2.resize(image, None, fx=SCALE, fy=SCALE, interpolation=shrink)
        cv2.imwrite(str(folder / f"{stem}.{name}"), small)
    pose = (sample / f"{stem}.pose.txt").read_bytes()
    (folder / f"{stem}.pose.txt").write_bytes(pose)
