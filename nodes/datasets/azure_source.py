"""A recording of an Azure Kinect (k4arecorder's ``.mkv``), as a source, through ``av`` (PyAV).

Tracks named COLOR (MJPEG) and DEPTH (16 bits, big endian, millimetres) and the attachment
``calibration.json``; no Kinect SDK is needed. Lenses are straightened, depth is registered to
colour by ingest. A colour image goes with the depth image nearest in time, at most 17 ms away.
Larger colour images are shrunk to ``color_side_px``. There are no poses.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, ClassVar

import cv2
import numpy as np

from sceneq_core.arrays import UInt8, UInt16
from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped
from sceneq_core.ingest.synchronizer import Synced, Synchronizer, SyncParams, Unmatched
from sceneq_core.ingest.undistortion import Undistortion
from sceneq_nodes._frame_files import lap_length
from sceneq_nodes._image_file import decode_rgb, header
from sceneq_nodes._recorded_source import RecordedParams
from sceneq_nodes._resized import resized
from sceneq_nodes.datasets.azure_calibration import read_calibration

TRACKS = ("COLOR", "DEPTH")
ATTACHMENT = "calibration.json"
MAX_APART_S = 0.017
NS_PER_S = 1_000_000_000
INSTALL = "Azure Kinect recordings need PyAV: pip install 'sceneq[azure]' (av)"


@dataclass(frozen=True, slots=True)
class AzureParams(RecordedParams):
    """``path`` of the file; ``color_side_px``: the longer side of colour images, at most."""

    color_side_px: int = 1280

    def __post_init__(self) -> None:
        RecordedParams.__post_init__(self)
        if self.color_side_px < 1:
            raise ValueError(f"color_side_px: expected 1 or more, got {self.color_side_px}")


class AzureSource:
    """Frames of a recording; ``seq`` counts those that have both images."""

    Params: ClassVar[type] = AzureParams

    def __init__(self, params: AzureParams) -> None:
        """Read calibration and sizes; raise ``ValueError`` on a file that cannot be played."""
        self._av = _pyav()
        self._params = params
        self._path = Path(params.path)
        color_size, depth_size, calibration = self._head()
        try:
            lenses = read_calibration(calibration, color_size, depth_size)
        except ValueError as error:
            raise ValueError(f"{self._path}: {error}") from error
        self.name = self._path.resolve().stem
        self.has_poses = False
        self._of_color, self._of_depth = Undistortion(lenses.color), Undistortion(lenses.depth)
        scale = min(1.0, params.color_side_px / max(color_size))
        self._size = round(color_size[0] * scale), round(color_size[1] * scale)
        self.color_camera = resized(Camera(lenses.color.K, color_size), self._size)
        self.depth_camera = Camera(lenses.depth.K, depth_size)
        self.T_color_depth = lenses.T_color_depth

    def frames(self) -> Iterator[RawFrame | Skipped]:
        """Yield one lap, or laps without end when looping; seq and stamps keep growing."""
        seq = add_ns = 0
        for _ in count() if self._params.loop else range(1):
            stamps: list[int] = []
            for stamp_ns, color, depth in self._pairs():
                if len(stamps) % self._params.step == 0:
                    yield self._frame(seq, stamp_ns + add_ns, color, depth)
                stamps.append(stamp_ns)
                seq += 1
            if not stamps:
                return
            add_ns += lap_length(stamps)

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """Refuse: what is recorded is recorded."""
        raise RefusedError("a recording cannot be changed", "a simulation can: sceneq up --sim")

    def _head(self) -> tuple[tuple[int, int], tuple[int, int], bytes]:
        """Return the sizes of colour and depth, and the calibration."""
        with self._opened() as file:
            color, depth = (self._track(file, name) for name in TRACKS)
            for stream in file.streams:
                if stream.type == "attachment" and stream.metadata.get("filename") == ATTACHMENT:
                    sizes = [
                        (s.codec_context.width, s.codec_context.height) for s in (color, depth)
                    ]
                    return sizes[0], sizes[1], bytes(stream.data)
        raise ValueError(f"{self._path}: no attachment {ATTACHMENT}: not of an Azure Kinect")

    def _track(self, file: Any, name: str) -> Any:
        for stream in file.streams.video:
            if stream.metadata.get("title") == name:
                return stream
        raise ValueError(f"{self._path}: no track {name}: not of an Azure Kinect")

    def _pairs(self) -> Iterator[tuple[int, bytes, bytes]]:
        """Yield stamp, JPEG and raw depth of images that belong together."""
        together: Synchronizer[bytes] = Synchronizer(SyncParams(MAX_APART_S), *TRACKS)
        with self._opened() as file:
            tracks = {self._track(file, name).index: name for name in TRACKS}
            for packet in file.demux(*(file.streams[index] for index in tracks)):
                if packet.pts is None:
                    continue
                stamp_ns = round(packet.pts * packet.time_base * NS_PER_S)
                yield from _pairs(
                    together.add(tracks[packet.stream.index], stamp_ns, bytes(packet))
                )
        yield from _pairs(together.flush())

    def _frame(self, seq: int, stamp_ns: int, color: bytes, depth: bytes) -> RawFrame:
        return RawFrame(
            seq=seq,
            stamp_ns=stamp_ns,
            T_world_camera=None,
            read_rgb=partial(self._rgb, seq, color),
            read_depth_mm=partial(self._depth_mm, seq, depth),
        )

    def _rgb(self, seq: int, data: bytes) -> UInt8 | Skipped:
        try:
            header(data)
            straight = self._of_color.rgb(decode_rgb(data))
        except ValueError as error:
            return Skipped(seq, f"{self._path}, frame {seq}", str(error))
        if self._size == straight.shape[1::-1]:
            return straight
        return np.asarray(cv2.resize(straight, self._size, interpolation=cv2.INTER_AREA), np.uint8)

    def _depth_mm(self, seq: int, data: bytes) -> UInt16 | Skipped:
        width, height = self.depth_camera.size
        if len(data) != 2 * width * height:
            reason = f"depth has {len(data)} bytes, expected {2 * width * height}"
            return Skipped(seq, f"{self._path}, frame {seq}", reason)
        pixels = np.frombuffer(data, ">u2").astype(np.uint16).reshape(height, width)
        return self._of_depth.depth_mm(pixels)

    def _opened(self) -> Any:
        try:
            return self._av.open(str(self._path))
        except (OSError, ValueError) as error:  # PyAV's errors are both
            raise ValueError(f"{self._path}: cannot be read: {error}") from error


def _pairs(settled: list[Synced[bytes] | Unmatched]) -> Iterator[tuple[int, bytes, bytes]]:
    for joined in settled:
        if isinstance(joined, Synced):
            color, depth = joined.items
            yield joined.stamp_ns, color, depth


def _pyav() -> Any:
    import importlib

    try:
        return importlib.import_module("av")
    except ImportError as error:
        raise ValueError(INSTALL) from error
