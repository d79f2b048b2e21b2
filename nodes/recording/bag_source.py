"""A bag of ROS 1 (.bag) or ROS 2 (a folder, .db3, .mcap), as a source.

Images (rgb8, bgr8, 16UC1, 32FC1, mono16, ..., JPEG, PNG, compressedDepth), camera_info and poses
are read and joined as from a live robot; static transforms count from the beginning. Topics that
are not named are found by type and name. Poses come from tf when it moves the camera, or from the
one topic of poses; without either the odometry finds them. World is the root of the camera's
frames.
"""

import logging
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import count, islice
from pathlib import Path
from types import SimpleNamespace
from typing import Any, ClassVar

from rosbags.highlevel import AnyReader, AnyReaderError
from rosbags.interfaces import Connection
from rosbags.typesys import Stores, get_typestore

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped, Waiting
from sceneq_nodes._frame_files import lap_length
from sceneq_nodes._paced_frames import paced
from sceneq_nodes.recording.bag_topics import (
    TF_STATIC,
    Names,
    camera_topics,
    is_tf,
    pose_of,
)
from sceneq_nodes.recording.mcap_source import McapParams
from sceneq_nodes.ros import assembly
from sceneq_nodes.ros.assembly import Assembly
from sceneq_nodes.ros.params import PoseParams, Ros2Params
from sceneq_nodes.ros.reader import CAMERA_INFO
from sceneq_nodes.ros.rig import Rig
from sceneq_nodes.ros.troubles import Troubles

log = logging.getLogger(__name__)

LOOKED_AT = 3000
"""So many transforms at the beginning of a bag say who moves."""
PATIENCE = 2000
"""So many images without a single frame are enough to say that there is none."""
NS_PER_S = 1e9


@dataclass(frozen=True, slots=True)
class BagParams(McapParams):
    """``path``, ``start_s``, ``speed`` and so on as of a recording of ours; topics as of a robot.

    What is empty is found in the bag. ``pose`` ``None``: looked for; else as of a live robot.
    """

    colour_topic: str = ""
    depth_topic: str = ""
    camera_info_topic: str = ""
    depth_info_topic: str = ""
    pose: PoseParams | None = None
    depth_registered: str = "auto"
    sync_tolerance_s: float = 0.02


class BagSource:
    """Frames of a bag; ``seq`` counts those that are complete."""

    Params: ClassVar[type] = BagParams

    def __init__(self, params: BagParams) -> None:
        """Read up to the first frame; raise ``ValueError`` on a bag that has none."""
        self._params = params
        self._path = Path(params.path)
        self.name = self._path.resolve().stem
        with self._opened() as reader:
            self._ros = self._settings(reader)
        self.has_poses = self._ros.pose.kind != "none"
        self._troubles = Troubles()
        self._rig = self._first_rig()

    @property
    def color_camera(self) -> Camera:
        """The colour camera without distortion."""
        return self._rig.color_camera

    @property
    def depth_camera(self) -> Camera:
        """The depth camera."""
        return self._rig.depth_camera

    @property
    def T_color_depth(self) -> Float64:
        """How they lie."""
        return self._rig.T_color_depth

    def frames(self) -> Iterator[RawFrame | Skipped | Waiting]:
        """Yield one lap, or laps without end when looping; seq and stamps keep growing."""
        return paced(self._laps(), self._params.speed)

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """Refuse: what is recorded is recorded."""
        raise RefusedError("a recording cannot be changed", "a simulation can: sceneq up --sim")

    def _laps(self) -> Iterator[RawFrame]:
        next_seq = add_ns = 0
        for _ in count() if self._params.loop else range(1):
            stamps = []
            for frame in self._lap(Assembly(self._ros, self._troubles, next_seq)):
                stamps.append(frame.stamp_ns)
                next_seq = frame.seq + 1
                if (len(stamps) - 1) % self._params.step == 0:
                    yield replace(frame, stamp_ns=frame.stamp_ns + add_ns)
            if not stamps:
                return
            add_ns += lap_length(stamps)

    def _lap(self, joined: Assembly) -> Iterator[RawFrame]:
        for role, message in self._messages():
            joined.take(role, message)
            yield from _complete(joined)
        joined.finish()
        yield from _complete(joined)
        if left := joined.finish():
            self._troubles.note("no_pose", f"{left} images at the end of the bag have none")

    def _messages(self) -> Iterator[tuple[str, Any]]:
        """Yield role and message, all static transforms first; what is damaged is a trouble."""
        with self._opened() as reader:
            roles = _roles(self._ros, reader)
            wanted = [c for c in reader.connections if c.topic in roles]
            static = [c for c in wanted if roles[c.topic] == assembly.TF_STATIC]
            moving = [c for c in wanted if roles[c.topic] != assembly.TF_STATIC]
            from_ns = reader.start_time + round(NS_PER_S * self._params.start_s)
            yield from self._read(reader, roles, static, reader.start_time)
            yield from self._read(reader, roles, moving, from_ns)

    def _read(
        self, reader: AnyReader, roles: dict[str, str], connections: list[Connection], start: int
    ) -> Iterator[tuple[str, Any]]:
        # Without any connection the reader would give all of them.
        for connection, _, data in reader.messages(connections, start) if connections else ():
            try:
                message = reader.deserialize(data, connection.msgtype)
            except AnyReaderError as error:
                self._troubles.note("undecodable", f"{connection.topic}: {error}")
                continue
            yield roles[connection.topic], _lower(message)

    def _first_rig(self) -> Rig:
        joined = Assembly(self._ros, self._troubles)
        for role, message in islice(self._messages(), PATIENCE):
            joined.take(role, message)
            if joined.frame() is not None and joined.rig is not None:
                return joined.rig
        said = self._troubles.text or "colour and depth never came together"
        topics = f"{self._ros.colour_topic}, {self._ros.depth_topic}"
        raise ValueError(f"{self._path}: no frame from {topics}: {said}")

    def _settings(self, reader: AnyReader) -> Ros2Params:
        """Return what a live robot would have been described by."""
        given = self._params
        types = {c.topic: c.msgtype for c in reader.connections}
        said = (given.colour_topic, given.depth_topic)
        for topic in filter(None, said):
            if topic not in types:
                raise ValueError(f"{self._path}: no topic {topic}; there are {', '.join(types)}")
        try:
            names = Names(*said, given.camera_info_topic, given.depth_info_topic)
            names = camera_topics(names, types)
        except ValueError as error:
            raise ValueError(f"{self._path}: {error}") from error
        if names.colour_info not in types:
            infos = [topic for topic, kind in types.items() if kind == CAMERA_INFO]
            there = ", ".join(infos) or "none"
            wanted = f"camera_info_topic: no topic {names.colour_info}"
            raise ValueError(f"{self._path}: {wanted}; of its type there are: {there}")
        pose = PoseParams("none")
        if given.use_poses:
            pose = given.pose or pose_of(
                types, _transforms(reader), _frame_of(reader, names.colour)
            )
        return Ros2Params(
            colour_topic=names.colour,
            depth_topic=names.depth,
            camera_info_topic=names.colour_info,
            depth_info_topic=names.depth_info,
            pose=pose,
            depth_registered=given.depth_registered,
            sync_tolerance_s=given.sync_tolerance_s,
        )

    @contextmanager
    def _opened(self) -> Iterator[AnyReader]:
        known = get_typestore(Stores.ROS2_JAZZY)  # of bags that do not say what their types are
        try:
            with AnyReader([self._path], default_typestore=known) as reader:
                yield reader
        except (AnyReaderError, OSError) as error:
            raise ValueError(f"{self._path}: {error}") from error


def _complete(joined: Assembly) -> Iterator[RawFrame]:
    while (frame := joined.frame()) is not None:
        yield frame


def _roles(ros: Ros2Params, reader: AnyReader) -> dict[str, str]:
    """Return topic -> what it is for."""
    tf = [c.topic for c in reader.connections if is_tf(c.topic, c.msgtype)]
    roles = {
        **{t: assembly.TF_STATIC if t.endswith(TF_STATIC) else assembly.TF for t in tf},
        ros.colour_info: assembly.COLOUR_INFO,
        ros.depth_info: assembly.DEPTH_INFO,
        ros.colour_topic: assembly.COLOUR,
        ros.depth_topic: assembly.DEPTH,
    }
    if ros.colour_info == ros.depth_info:
        roles[ros.colour_info] = assembly.COLOUR_INFO
    if ros.pose.kind == "topic":
        roles[ros.pose.topic] = assembly.POSE
    return roles


def _transforms(reader: AnyReader) -> Iterator[tuple[Any, bool]]:
    """Yield the transforms of the bag's beginning, and whether they are static."""
    wanted = [c for c in reader.connections if is_tf(c.topic, c.msgtype)]
    for connection, _, data in islice(reader.messages(wanted), LOOKED_AT) if wanted else ():
        message: Any = reader.deserialize(data, connection.msgtype)
        for stamped in message.transforms:
            yield stamped, connection.topic.endswith(TF_STATIC)


def _frame_of(reader: AnyReader, topic: str) -> str:
    """Return the frame that the first image of ``topic`` names."""
    wanted = [c for c in reader.connections if c.topic == topic]
    for connection, _, data in reader.messages(wanted):
        message: Any = reader.deserialize(data, connection.msgtype)
        return str(message.header.frame_id)
    return ""


def _lower(message: Any) -> Any:
    """Return a CameraInfo of ROS 1, with D, K, R and P, as one of ROS 2; others as they are."""
    if not hasattr(message, "K"):
        return message
    same = ("header", "height", "width", "distortion_model", "binning_x", "binning_y", "roi")
    matrices = {name.lower(): getattr(message, name) for name in "DKRP"}
    return SimpleNamespace(**{name: getattr(message, name) for name in same}, **matrices)
