"""Source kind ``ros2``: a robot's camera, live, from its ROS 2 topics over Zenoh.

No ROS is needed here: messages come in the wire form of rmw_zenoh or of zenoh-bridge-ros2dds, and
``rosbags`` decodes them. What is wrong with them is said in the log, counted as ``ros_<kind>`` and
shown by `sceneq status` as ``trouble`` for as long as it lasts.
"""

import time
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any, ClassVar

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped, Waiting
from sceneq_nodes._bus import Bus, foreign_keys
from sceneq_nodes._credentials import given_credentials
from sceneq_nodes.ros import assembly
from sceneq_nodes.ros.assembly import Assembly
from sceneq_nodes.ros.keys import selectors
from sceneq_nodes.ros.mailbox import Mailbox
from sceneq_nodes.ros.params import Ros2Params
from sceneq_nodes.ros.reader import CAMERA_INFO, POINTS, TF_MESSAGE, Reader, TopicRole, image_role
from sceneq_nodes.ros.rig import Rig
from sceneq_nodes.ros.troubles import Troubles
from sceneq_nodes.ros.typestore import typestore

SECURED = "; with 'secure' only topics pass that 'sceneq secure init --graph' was told"
QUIET_S = 1.0
DAY_S = 86_400
SEQ_HZ = 100
"""Numbers grow faster than any camera: a source that starts again the same day reuses none."""


class Ros2Source:
    """Frames as they come, for ever; ``Waiting`` in between."""

    Params: ClassVar[type] = Ros2Params

    def __init__(self, params: Ros2Params, clock: Callable[[], float] = time.monotonic) -> None:
        self.name = "ros2"
        self.has_poses = params.has_poses
        self._params = params
        self._clock = clock
        self._mailbox = Mailbox()
        self._heard_s: dict[str, float] = {}
        self._assembly: Assembly | None = None

    def connect(self, bus: Bus) -> None:
        """Listen to the topics; raise ``ValueError`` where there is no network."""
        keys, params = foreign_keys(bus), self._params
        self._bus = bus
        self._troubles = Troubles(bus.count)
        self._is_secured = given_credentials() is not None
        store = typestore(params.distro)
        seq = int(time.time() % DAY_S * SEQ_HZ)
        self._assembly = Assembly(params, self._troubles, seq)
        self._readers = {t.role: Reader(t, store, self._troubles) for t in topic_roles(params)}
        self._connected_s = self._clock()
        for topic in topic_roles(params):
            for selector in selectors(topic.topic, params.domain, params.dialect):
                take = partial(self._mailbox.put, topic.role)
                keys.listen(selector, take, latched=topic.latched)

    @property
    def color_camera(self) -> Camera:
        """The colour camera without distortion, known from the first frame on."""
        return self._rig.color_camera

    @property
    def depth_camera(self) -> Camera:
        """The depth camera, known from the first frame on."""
        return self._rig.depth_camera

    @property
    def T_color_depth(self) -> Float64:
        """How they lie, known from the first frame on."""
        return np.array(self._rig.T_color_depth)

    def frames(self) -> Iterator[RawFrame | Skipped | Waiting]:
        """Yield what has come, ``Waiting`` when that is nothing; goes on where it was."""
        while True:
            frame = self._next()
            self._tell()
            yield Waiting() if frame is None else frame

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """Refuse: the room is a real one."""
        raise RefusedError("a robot's room cannot be changed", "a simulation can: sceneq up --sim")

    @property
    def _rig(self) -> Rig:
        if self._assembly is None or self._assembly.rig is None:
            raise ValueError(f"{self.name}: the cameras are not known before the first frame")
        return self._assembly.rig

    def _next(self) -> RawFrame | None:
        """Return the next complete frame, with no more messages decoded than that takes."""
        if self._assembly is None:
            raise ValueError(f"{self.name}: not connected")
        frame = self._assembly.frame()
        while frame is None and (taken := self._mailbox.take()) is not None:
            role, sample = taken
            self._heard_s[role] = self._clock()
            message = self._readers[role].read(sample)
            if message is not None:
                self._assembly.take(role, message)
                frame = self._assembly.frame()
        if frame is None and self._is_quiet():
            self._assembly.finish()
            frame = self._assembly.frame()
        return frame

    def _is_quiet(self) -> bool:
        """Tell whether no image has come for so long that none will come for those that wait."""
        heard_s = [
            s for role, s in self._heard_s.items() if role in (assembly.COLOUR, assembly.DEPTH)
        ]
        return bool(heard_s) and self._clock() - max(heard_s) > QUIET_S

    def _tell(self) -> None:
        if dropped := self._mailbox.dropped():
            self._bus.count("ros_messages_dropped", dropped)
        now_s, patience_s = self._clock(), self._params.patience_s
        for topic in topic_roles(self._params):
            if topic.role in assembly.QUIET:
                continue
            silent_s = now_s - self._heard_s.get(topic.role, self._connected_s)
            if silent_s < patience_s:
                self._troubles.over(f"silent_{topic.role}")
            elif not self._troubles.is_lasting(f"silent_{topic.role}"):
                text = f"nothing on {topic.topic} for {silent_s:.0f} s{self._hint()}"
                self._troubles.lasts(f"silent_{topic.role}", text)
        self._bus.report(trouble=self._troubles.text)

    def _hint(self) -> str:
        """Name the domain where keys have one: a wrong one looks like silence, so does a denial."""
        params = self._params
        domain = "" if params.dialect == "bridge" else f" (ROS_DOMAIN_ID {params.domain})"
        return domain + (SECURED if self._is_secured else "")


def topic_roles(params: Ros2Params) -> list[TopicRole]:
    """Return the topics that a source listens to."""
    roles = [
        image_role(assembly.COLOUR, params.colour_topic),
        TopicRole(assembly.COLOUR_INFO, params.colour_info, (CAMERA_INFO,)),
        TopicRole(assembly.TF, "/tf", (TF_MESSAGE,)),
        TopicRole(assembly.TF_STATIC, "/tf_static", (TF_MESSAGE,), latched=True),
    ]
    if params.points_topic:
        roles.append(TopicRole(assembly.DEPTH, params.points_topic, (POINTS,)))
    else:
        roles.append(image_role(assembly.DEPTH, params.depth_topic))
        roles.append(TopicRole(assembly.DEPTH_INFO, params.depth_info, (CAMERA_INFO,)))
    if params.pose.kind == "topic":
        roles.append(TopicRole(assembly.POSE, params.pose.topic, (params.pose.type,)))
    return roles
