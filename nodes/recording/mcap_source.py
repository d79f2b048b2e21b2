"""A recording of ours (``sceneq record``), as a source: keyframes, exactly as they were.

Image by image and pose by pose the frames are those of the run, so its map comes out again, bit
for bit; corrections of poses come with the keyframes they came with. Every frame is a keyframe: the
policy has to be ``{kind: every, every: 1}``, which ``--source`` says by itself. A file whose writer
was killed ends where it is cut off.
"""

import logging
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from sceneq_core.arrays import Float64, UInt8, UInt16
from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped, Waiting
from sceneq_core.ingest.transforms import rigid_defect
from sceneq_nodes._frame_files import lap_length
from sceneq_nodes._paced_frames import paced
from sceneq_nodes._recorded_source import RecordedParams
from sceneq_nodes._wire import from_bytes
from sceneq_nodes.recording import forms
from sceneq_nodes.recording.mcap_reader import Recorded, library_of, recorded
from sceneq_nodes.recording.mcap_writer import LIBRARY
from sceneq_nodes.ros.pictures import compressed_rgb, image_depth_mm, image_rgb
from sceneq_nodes.ros.stamped_poses import stamp_ns
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import POSE_CORRECTION

log = logging.getLogger(__name__)

PARTS = {
    forms.COLOR: "color",
    forms.COLOR_JPEG: "color",
    forms.DEPTH: "depth",
    forms.CAMERA: "camera",
}
Pixels = TypeVar("Pixels", UInt8, UInt16)
TOPICS = (*PARTS, forms.KEYFRAME, forms.CORRECTION)


@dataclass(frozen=True, slots=True)
class McapParams(RecordedParams):
    """``path`` of the file; ``start_s``: leave out so many seconds at its beginning.

    ``speed``: 1 = as fast as it was recorded, 0 = as fast as it is taken.
    """

    start_s: float = 0.0
    speed: float = 0.0

    def __post_init__(self) -> None:
        RecordedParams.__post_init__(self)
        for name in ("start_s", "speed"):
            if not 0 <= getattr(self, name) < float("inf"):
                raise ValueError(f"{name}: expected 0 or more, got {getattr(self, name)}")


@dataclass(slots=True, eq=False)
class _Keyframe:
    """The messages of one keyframe, by part, and the corrections that came before it."""

    stamp_ns: int
    parts: dict[str, tuple[str, Any]] = field(default_factory=dict)
    seq: int = -1
    T_world_camera: Float64 = field(default_factory=lambda: np.eye(4))
    corrected: dict[int, Float64] = field(default_factory=dict)

    def keep_corrected(self, seqs: Collection[int]) -> None:
        """Forget what is better known of keyframes that were left out."""
        self.corrected = {seq: T for seq, T in self.corrected.items() if seq in seqs}


class McapSource:
    """Keyframes of a recording; ``seq`` is that of the run and goes on from lap to lap."""

    Params: ClassVar[type] = McapParams

    def __init__(self, params: McapParams) -> None:
        """Read the first keyframe; raise ``ValueError`` on a file that cannot be played."""
        self._params = params
        self._path = Path(params.path)
        if library_of(self._path) != LIBRARY:
            hint = "a bag of ROS 2 has the source kind 'rosbag'"
            raise ValueError(f"{self._path}: no recording of 'sceneq record' ({hint})")
        first = next(_keyframes(self._path, 0), None)
        if first is None:
            raise ValueError(f"{self._path}: no keyframe in it")
        self._first_ns = first.stamp_ns
        camera = _camera(first)
        if isinstance(camera, str):
            raise ValueError(f"{self._path}: keyframe {first.seq}: {camera}")
        self.name = self._path.resolve().stem
        self.color_camera = self.depth_camera = camera
        self.T_color_depth = np.eye(4)
        self.has_poses = params.use_poses

    def frames(self) -> Iterator[RawFrame | Skipped | Waiting]:
        """Yield one lap, or laps without end when looping; seq and stamps keep growing."""
        return paced(self._laps(), self._params.speed)

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """Refuse: what is recorded is recorded."""
        raise RefusedError("a recording cannot be changed", "a simulation can: sceneq up --sim")

    def _laps(self) -> Iterator[RawFrame | Skipped]:
        params = self._params
        start_ns = round(params.start_s * forms.NS_PER_S)
        from_ns = self._first_ns + start_ns if start_ns else 0
        add_seq = add_ns = 0
        for _ in count() if params.loop else range(1):
            seqs, stamps, played = [], [], set()
            for number, keyframe in enumerate(_keyframes(self._path, from_ns)):
                seqs.append(keyframe.seq)
                stamps.append(keyframe.stamp_ns)
                if number % params.step == 0:
                    played.add(keyframe.seq)
                    keyframe.keep_corrected(played)
                    yield self._frame(keyframe, add_seq, add_ns)
            if not seqs:
                return
            add_seq, add_ns = add_seq + lap_length(seqs), add_ns + lap_length(stamps)

    def _frame(self, keyframe: _Keyframe, add_seq: int, add_ns: int) -> RawFrame | Skipped:
        seq, where = keyframe.seq + add_seq, f"{self._path}, keyframe {keyframe.seq}"
        camera = _camera(keyframe)
        if isinstance(camera, str):
            return Skipped(seq, where, camera)
        if camera.size != self.color_camera.size or (camera.K != self.color_camera.K).any():
            return Skipped(seq, where, "of another camera than the first")
        if defect := rigid_defect(keyframe.T_world_camera):
            return Skipped(seq, where, defect)
        return RawFrame(
            seq=seq,
            stamp_ns=keyframe.stamp_ns + add_ns,
            T_world_camera=keyframe.T_world_camera if self.has_poses else None,
            read_rgb=partial(_rgb, keyframe, seq, where),
            read_depth_mm=partial(_depth_mm, keyframe, seq, where),
            corrected={n + add_seq: T for n, T in keyframe.corrected.items()},
        )


def _keyframes(path: Path, from_ns: int) -> Iterator[_Keyframe]:
    """Yield what is complete; a keyframe that was cut off never got its last message."""
    current = _Keyframe(-1)
    waiting: list[tuple[int, dict[int, Float64]]] = []
    for one in recorded(path, TOPICS, from_ns):
        if one.topic == forms.CORRECTION:
            waiting += _correction(one)
            continue
        message = _decoded(one)
        if message is None:
            continue
        at_ns = stamp_ns(message.header.stamp)
        if at_ns != current.stamp_ns:
            current = _Keyframe(at_ns)
        if one.topic != forms.KEYFRAME:
            current.parts[PARTS[one.topic]] = one.type_name, message
            continue
        current.seq = int(message.seq)
        current.T_world_camera = message.t_world_camera.reshape(4, 4).astype(np.float64)
        for _, poses in [w for w in waiting if w[0] <= current.seq]:
            current.corrected |= poses
        waiting = [w for w in waiting if w[0] > current.seq]
        yield current
        current = _Keyframe(-1)


def _correction(one: Recorded) -> list[tuple[int, dict[int, Float64]]]:
    packed = _decoded(one)
    try:
        message = from_bytes(POSE_CORRECTION, b"" if packed is None else packed.data.tobytes())
    except DecodeError:
        return []  # of a later schema: the keyframes are as they were all the same
    poses = zip(message.keyframe_seq.tolist(), message.T_world_camera, strict=True)
    return [(message.frame_seq, dict(poses))]


def _decoded(one: Recorded) -> Any | None:
    """Return the message, ``None`` for bytes that are none: of those anything may be raised."""
    try:
        return forms.store().deserialize_cdr(one.data, one.type_name)
    except Exception as error:
        log.warning("%s at %d ns is damaged: %r", one.topic, one.log_ns, error)
        return None


def _camera(keyframe: _Keyframe) -> Camera | str:
    """Return the camera, or what is wrong with it."""
    missing = {"color", "depth", "camera"} - set(keyframe.parts)
    if missing:
        return f"no {', '.join(sorted(missing))} in it"
    info = keyframe.parts["camera"][1]
    K = info.k.reshape(3, 3).astype(np.float64)
    if not (np.isfinite(K).all() and K[0, 0] > 0 and K[1, 1] > 0 and info.width and info.height):
        return f"no camera: {info.width}x{info.height}, {K.tolist()}"
    return Camera(K, (int(info.width), int(info.height)))


def _rgb(keyframe: _Keyframe, seq: int, where: str) -> UInt8 | Skipped:
    type_name, message = keyframe.parts["color"]
    decode = compressed_rgb if type_name.endswith("CompressedImage") else image_rgb
    return _checked(decode, message, keyframe, seq, where)


def _depth_mm(keyframe: _Keyframe, seq: int, where: str) -> UInt16 | Skipped:
    return _checked(image_depth_mm, keyframe.parts["depth"][1], keyframe, seq, where)


def _checked(
    decode: Callable[[Any], Pixels], message: Any, keyframe: _Keyframe, seq: int, where: str
) -> Pixels | Skipped:
    info = keyframe.parts["camera"][1]
    try:
        pixels = decode(message)
    except ValueError as error:
        return Skipped(seq, where, str(error))
    if pixels.shape[:2] != (info.height, info.width):
        return Skipped(seq, where, f"image of {pixels.shape[1]}x{pixels.shape[0]}")
    return pixels
