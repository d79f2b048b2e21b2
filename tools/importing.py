"""Frames of a source written as a folder in the layout of 7-Scenes, or as an MCAP recording."""

import json
from collections.abc import Callable, Iterator, Sized
from dataclasses import dataclass, field, replace
from pathlib import Path

import cv2
import numpy as np

from sceneq_core.arrays import Array, UInt8
from sceneq_core.frame import Frame
from sceneq_core.ingest.ingestor import Ingestor
from sceneq_core.ingest.keyframes import EveryNth, EveryNthParams
from sceneq_core.ingest.source import RawFrame, Skipped, Source
from sceneq_nodes._camera_files import COLOR, INTRINSICS, STAMPS
from sceneq_nodes._images import frame_message
from sceneq_schemas.frame import Frame as FrameMessage
from sceneq_tools.batch import Stage
from sceneq_tools.errors import UserError
from sceneq_tools.record_option import need_new_file

NS_PER_S = 1e9


@dataclass(slots=True)
class Import:
    """A conversion: ``stage`` does it, the rest says what became of it so far."""

    frames: int = 0
    skipped: int = 0
    first_reason: str = ""
    stage: Stage = field(init=False)

    def skip(self, bad: Skipped) -> None:
        """Count a frame that is left out."""
        self.skipped += 1
        self.first_reason = self.first_reason or f"{bad.where}: {bad.reason}"


def import_folder(source: Source, folder: Path, quality: int | None) -> Import:
    """Return what writes ``source`` into a new folder; ``quality`` of JPEG, ``None`` = PNG.

    Raises:
        UserError: there is something at ``folder`` already.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UserError(f"{folder}: is there already; take another name", 2)
    return _import(source, lambda done: _write_folder(source, folder, quality, done))


def import_mcap(source: Source, path: Path, quality: int | None) -> Import:
    """Return what writes every frame of ``source`` as a keyframe of a recording.

    Raises:
        UserError: there is such a file already, or the source has no poses.
    """
    need_new_file(path)
    if not source.has_poses:
        hint = f"find and record them: sceneq up --source ... --record {path}"
        raise UserError(f"{source.name} has no poses ({hint})", 2)
    return _import(source, lambda done: _write_mcap(source, path, quality, done))


def _import(source: Source, steps: Callable[[Import], Iterator[int]]) -> Import:
    done = Import()
    total = len(source) if isinstance(source, Sized) else None
    done.stage = Stage("frames", total, steps(done))
    return done


def _write_folder(source: Source, folder: Path, quality: int | None, done: Import) -> Iterator[int]:
    folder.mkdir(parents=True, exist_ok=True)
    _write_cameras(source, folder)
    stamps_s = []
    for number, frame in enumerate(source.frames(), 1):
        written = frame if isinstance(frame, Skipped) else _write_frame(frame, folder, quality)
        if isinstance(written, Skipped):
            done.skip(written)
        elif isinstance(frame, RawFrame):
            done.frames += 1
            stamps_s.append(frame.stamp_ns / NS_PER_S)
        yield number
    (folder / STAMPS).write_text("".join(f"{stamp_s:.9f}\n" for stamp_s in stamps_s))


def _write_cameras(source: Source, folder: Path) -> None:
    np.savetxt(folder / INTRINSICS, source.depth_camera.K)
    color, depth = source.color_camera, source.depth_camera
    is_one = color.size == depth.size and np.array_equal(color.K, depth.K)
    if not (is_one and np.array_equal(source.T_color_depth, np.eye(4))):
        cameras = {"K": color.K.tolist(), "T_color_depth": source.T_color_depth.tolist()}
        (folder / COLOR).write_text(json.dumps(cameras))


def _write_frame(frame: RawFrame, folder: Path, quality: int | None) -> Skipped | None:
    rgb, depth_mm = frame.read_rgb(), frame.read_depth_mm()
    if isinstance(rgb, Skipped):
        return rgb
    if isinstance(depth_mm, Skipped):
        return depth_mm
    stem = folder / f"frame-{frame.seq:06d}"
    color = _encoded(rgb[..., ::-1], ".png") if quality is None else _jpeg(rgb, quality)
    Path(f"{stem}.color.{'png' if quality is None else 'jpg'}").write_bytes(color)
    Path(f"{stem}.depth.png").write_bytes(_encoded(depth_mm, ".png"))
    if frame.T_world_camera is not None:
        np.savetxt(f"{stem}.pose.txt", frame.T_world_camera)
    return None


def _jpeg(rgb: UInt8, quality: int) -> bytes:
    return _encoded(rgb[..., ::-1], ".jpg", cv2.IMWRITE_JPEG_QUALITY, quality)


def _encoded(image: Array, suffix: str, *options: int) -> bytes:
    return bytes(cv2.imencode(suffix, np.ascontiguousarray(image), options)[1].tobytes())


def _write_mcap(source: Source, path: Path, quality: int | None, done: Import) -> Iterator[int]:
    from sceneq_nodes.recording.forms import keyframe_said
    from sceneq_nodes.recording.mcap_writer import McapWriter

    ingestor = Ingestor(source, EveryNth(EveryNthParams(every=1)))
    writer = McapWriter(path)
    try:
        for number, raw in enumerate(source.frames(), 1):
            taken = raw if isinstance(raw, Skipped) else ingestor.ingest(raw)
            if isinstance(taken, Skipped):
                done.skip(taken)
            elif taken.keyframe is not None:
                done.frames += 1
                for said in keyframe_said(_message(taken.keyframe, quality)):
                    writer.write(said)
            yield number
    finally:
        writer.close()


def _message(keyframe: Frame, quality: int | None) -> FrameMessage:
    message = frame_message(keyframe, "raw", "raw")
    if quality is None:
        return message
    data = _jpeg(keyframe.rgb, quality)
    return replace(message, rgb=replace(message.rgb, codec="jpeg", data=data))
