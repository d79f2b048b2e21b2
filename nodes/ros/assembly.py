"""From decoded ROS messages to frames of a source; knows no network, no key and no clock."""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from sceneq_core.arrays import Float64, UInt8, UInt16
from sceneq_core.ingest.frame_tree import NS_PER_S, FrameError
from sceneq_core.ingest.source import RawFrame, Skipped
from sceneq_core.ingest.synchronizer import Synced, Synchronizer, SyncParams, Unmatched
from sceneq_core.ingest.undistortion import Lens
from sceneq_nodes.ros.camera_info import is_rectified, lens
from sceneq_nodes.ros.params import Ros2Params
from sceneq_nodes.ros.pictures import (
    compressed_depth_mm,
    compressed_rgb,
    image_depth_mm,
    image_rgb,
)
from sceneq_nodes.ros.poses import Poses
from sceneq_nodes.ros.rig import FirstFrame, Rig, UnsettledError, settle
from sceneq_nodes.ros.scans import ScanOdometry, scan_depth_mm
from sceneq_nodes.ros.stamped_poses import frame_name, stamp_ns
from sceneq_nodes.ros.troubles import Troubles
from sceneq_nodes.ros.typestore import WireError

COLOUR, DEPTH = "colour", "depth"
COLOUR_INFO, DEPTH_INFO = "colour_info", "depth_info"
TF, TF_STATIC, POSE = "tf", "tf_static", "pose"
QUIET = (TF, TF_STATIC, DEPTH_INFO)
"""Roles whose silence may be right: whether they are needed shows in the frames."""
UNSYNCED_AFTER = 15
"""So many colour images in a row without depth are no accident."""


@dataclass(frozen=True, slots=True, eq=False)
class _Picture:
    """An image message that waits for its partner or its pose."""

    stamp_ns: int
    frame: str
    message: Any

    @property
    def size(self) -> tuple[int, int] | None:
        """(width, height); ``None`` for a compressed image, which does not say it."""
        message = self.message
        return (message.width, message.height) if hasattr(message, "step") else None


class Assembly:
    """Joins colour, depth and pose of one camera; each message goes to ``take``, by its role."""

    def __init__(self, params: Ros2Params, troubles: Troubles, first_seq: int = 0) -> None:
        self._params = params
        self._troubles = troubles
        self._poses = Poses(params.pose, troubles)
        self._lenses: dict[str, Lens] = {}
        self._sync: Synchronizer[_Picture] = Synchronizer(
            SyncParams(params.sync_tolerance_s, params.capacity), COLOUR, DEPTH
        )
        self._last_ns: dict[str, int] = {}
        self._newest_ns = 0
        self._alone = 0
        self._colour_frame = ""
        self._due: deque[tuple[_Picture, _Picture]] = deque()
        self._next_seq = first_seq
        self._scans: ScanOdometry | None = None
        if params.points_topic and params.pose.kind == "none":
            self._scans = ScanOdometry(params.lidar_odometry, troubles)
        self.rig: Rig | None = None
        self._take: dict[str, Callable[[Any], None]] = {
            COLOUR: partial(self._take_picture, COLOUR),
            DEPTH: partial(self._take_picture, DEPTH),
            COLOUR_INFO: partial(self._take_info, COLOUR_INFO),
            DEPTH_INFO: partial(self._take_info, DEPTH_INFO),
            TF: lambda message: self._poses.take_tf(message, is_static=False),
            TF_STATIC: lambda message: self._poses.take_tf(message, is_static=True),
            POSE: lambda message: self._poses.take_pose(message, self._colour_frame),
        }

    def take(self, role: str, message: Any) -> None:
        """Take one decoded message, in the order in which they came."""
        self._take[role](message)

    def frame(self) -> RawFrame | None:
        """Return the next frame that is complete, ``None`` when none is so far."""
        while self._due:
            rig = self.rig or self._settle()
            if rig is None:
                return None
            colour, depth = self._due[0]
            try:
                T_world_depth = self._pose(rig, colour, depth)
            except FrameError as error:
                self._troubles.lasts("no_pose", str(error))
                self._due.popleft()
                continue
            if T_world_depth is None and self._params.has_poses:
                return None
            self._due.popleft()
            self._troubles.over("no_pose")
            if self._fits(rig, colour, depth):
                return self._raw_frame(rig, colour, depth, T_world_depth)
        return None

    def _take_picture(self, stream: str, message: Any) -> None:
        frame = frame_name(message.header.frame_id)
        if stream == COLOUR:
            frame = self._colour_frame = self._params.pose.camera_frame or frame
        picture = _Picture(stamp_ns(message.header.stamp), frame, message)
        if not self._keeps_time(stream, picture.stamp_ns):
            return
        if stream == DEPTH and self._scans is not None:
            self._scans.add(picture.stamp_ns, message)
        self._settle_pairs(self._sync.add(stream, picture.stamp_ns, picture))

    def finish(self) -> int:
        """Join what waits for something nearer: nothing comes. Return how many wait for a pose."""
        self._settle_pairs(self._sync.flush())
        return len(self._due)

    def _settle_pairs(self, pairs: "list[Synced[_Picture] | Unmatched]") -> None:
        for settled in pairs:
            if isinstance(settled, Synced):
                self._alone = 0
                self._troubles.over("unsynced")
                self._queue(settled.items)
            else:
                self._note_alone(settled)

    def _queue(self, pair: tuple[_Picture, ...]) -> None:
        """Keep a pair until its pose comes, for as long as poses are waited for at 60 Hz."""
        if len(self._due) >= self._params.capacity + 60 * self._params.pose.wait_s:
            self._due.popleft()
            self._troubles.note("frames_dropped", "frames come faster than they are taken")
        self._due.append((pair[0], pair[1]))

    def _note_alone(self, unmatched: Unmatched) -> None:
        self._troubles.tally(f"{unmatched.stream}_alone")
        if unmatched.stream == DEPTH:
            return
        self._alone += 1
        if self._alone >= UNSYNCED_AFTER and unmatched.apart_s is not None:
            text = (
                f"no depth within {self._params.sync_tolerance_s:g} s of colour, the nearest is "
                f"{unmatched.apart_s:.3g} s away: do both have one clock? (sync_tolerance_s)"
            )
            self._troubles.lasts("unsynced", text)

    def _keeps_time(self, stream: str, at_ns: int) -> bool:
        """Tell whether a stamp may go on; after a jump back everything starts anew."""
        last_ns = self._last_ns.get(stream)
        step_s = 0.0 if last_ns is None else (at_ns - last_ns) / NS_PER_S
        if last_ns is not None and -self._params.clock_jump_s < step_s <= 0:
            self._troubles.note("out_of_order", f"{stream}: stamp goes back by {-step_s:.3f} s")
            return False
        if step_s < 0:
            self._troubles.note("clock_back", f"{stream}: clock jumped back by {-step_s:.3f} s")
            self._start_anew(at_ns)
        elif step_s > self._params.clock_jump_s:
            self._troubles.note(
                "clock_ahead", f"{stream}: clock jumped ahead by {step_s:.3f} s, or it was silent"
            )
        self._last_ns[stream] = at_ns
        self._newest_ns = max(self._newest_ns, at_ns)
        return True

    def _start_anew(self, at_ns: int) -> None:
        self._sync.clear()
        self._due.clear()
        self._last_ns.clear()
        self._poses.set_back(at_ns)
        self._newest_ns = 0

    def _take_info(self, role: str, message: Any) -> None:
        topic = self._params.colour_topic if role == COLOUR_INFO else self._params.depth_topic
        try:
            found = lens(message, is_rectified(topic))
            self._troubles.over(f"bad_{role}")
        except WireError as error:
            self._troubles.lasts(f"bad_{role}", str(error))
            return
        known = self._lenses.setdefault(role, found)
        if self.rig is None:
            self._lenses[role] = found
        elif not known.is_like(found):
            text = f"{role} is another one than at the start: start ingest again to take it"
            self._troubles.lasts(f"changed_{role}", text)
        else:
            self._troubles.over(f"changed_{role}")

    def _settle(self) -> Rig | None:
        colour, depth = self._due[0]
        first = FirstFrame(colour.stamp_ns, colour.frame, depth.frame, depth.size)
        try:
            self.rig = settle(self._params, self._lenses, self._poses.tree, first)
        except UnsettledError as error:
            waited_s = (self._newest_ns - self._due[0][0].stamp_ns) / NS_PER_S
            if waited_s >= self._params.pose.wait_s:
                self._troubles.lasts(error.kind, str(error))
                self._due.popleft()
            return None
        for kind in ("no_camera_info", "unregistered_depth", "no_extrinsics"):
            self._troubles.over(kind)
        return self.rig

    def _fits(self, rig: Rig, colour: _Picture, depth: _Picture) -> bool:
        """Tell whether both images have the size of their cameras."""
        for name, picture, camera in ((COLOUR, colour, rig.colour), (DEPTH, depth, rig.depth)):
            if picture.size not in (None, camera.size):
                width, height = picture.size or (0, 0)
                text = f"{name} is {width}x{height}, its camera_info says "
                self._troubles.lasts(
                    "resolution", f"{text}{camera.size[0]}x{camera.size[1]}: frames are left out"
                )
                return False
        self._troubles.over("resolution")
        return True

    def _pose(self, rig: Rig, colour: _Picture, depth: _Picture) -> Float64 | None:
        """Return T_world_camera (4, 4) of what measured depth; of scans, of the colour camera."""
        if not self._params.has_poses:
            return None
        if self._scans is not None and rig.T_camera_lidar is not None:
            T_world_camera = self._scans.pose(depth.stamp_ns, rig.T_camera_lidar)
            if T_world_camera is None:
                raise FrameError("no pose of this scan")
            return T_world_camera
        frame = depth.frame if rig.T_camera_lidar is None else colour.frame
        return self._poses.lookup(frame, depth.stamp_ns, self._newest_ns)

    def _raw_frame(
        self, rig: Rig, colour: _Picture, depth: _Picture, T_world_depth: Float64 | None
    ) -> RawFrame:
        seq, self._next_seq = self._next_seq, self._next_seq + 1
        return RawFrame(
            seq=seq,
            stamp_ns=colour.stamp_ns,
            T_world_camera=T_world_depth,
            read_rgb=partial(_read_rgb, rig, colour.message, seq, self._params.colour_topic),
            read_depth_mm=self._depth_reader(rig, depth.message, seq),
        )

    def _depth_reader(self, rig: Rig, message: Any, seq: int) -> Callable[[], UInt16 | Skipped]:
        params = self._params
        where = seq, params.range_topic
        if rig.T_camera_lidar is None:
            return partial(_read_depth, rig, message, *where)
        camera = rig.depth_camera
        return partial(
            scan_depth_mm, message, rig.T_camera_lidar, camera, params.lidar_depth, where
        )


def _read_rgb(rig: Rig, message: Any, seq: int, topic: str) -> UInt8 | Skipped:
    try:
        decode = image_rgb if hasattr(message, "step") else compressed_rgb
        return rig.undistort_colour.rgb(decode(message))
    except ValueError as error:
        return Skipped(seq, topic, str(error))


def _read_depth(rig: Rig, message: Any, seq: int, topic: str) -> UInt16 | Skipped:
    try:
        decode = image_depth_mm if hasattr(message, "step") else compressed_depth_mm
        return np.ascontiguousarray(rig.undistort_depth.depth_mm(decode(message)))
    except ValueError as error:
        return Skipped(seq, topic, str(error))
