"""The ray-cast room as rooms of a suite."""

import shutil
from pathlib import Path

import cv2

from sceneq_tools.room.truth.recording_files import NAMES
from sceneq_tools.suite import SuiteParams, SuiteRoom, make_suite
from sceneq_tools.synth import SynthParams

from support.questioned import write_questioned

ROOMS = (SuiteRoom("tuning", "office", 1), SuiteRoom("test", "kitchen", 2))
FRAMES = 6


def write_room(params: SynthParams, folder: Path) -> None:
    """Write a recording with everything that belongs to a room of a suite."""
    write_questioned(folder, params.frames)
    for path in folder.glob("frame-*.instance.png"):
        shutil.copy(path, path.with_name(path.name.replace("instance", "mask")))
    for path in folder.glob("frame-*.color.png"):
        cv2.imwrite(str(path.with_suffix(".jpg")), cv2.imread(str(path)))
        path.unlink()
    for name in NAMES:
        if not (folder / name).exists():
            text = "\n".join(map(str, range(params.frames))) if name == "stamps.txt" else ""
            (folder / name).write_text(text)


def write_suite(folder: Path, frames: int = FRAMES) -> Path:
    """Write the two rooms and suite.json."""
    params = SuiteParams(frames, rate_hz=1.0, size=(64, 48), every=1)
    make_suite(folder, params, "ray-cast", write_room, quiet=True, rooms=ROOMS)
    return folder
