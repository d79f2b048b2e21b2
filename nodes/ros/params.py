"""What the user says about a robot's topics."""

from dataclasses import dataclass, field

from sceneq_core.checks import need_at_least, need_positive
from sceneq_core.ingest.lidar_depth import LidarDepthParams
from sceneq_core.ingest.lidar_odometry import LidarOdometryParams
from sceneq_nodes.ros.camera_info import info_topic
from sceneq_nodes.ros.keys import DIALECTS, topic_path
from sceneq_nodes.ros.typestore import DISTROS

ODOMETRY, POSE_STAMPED = "nav_msgs/msg/Odometry", "geometry_msgs/msg/PoseStamped"
POSE_KINDS = ("none", "tf", "topic")
REGISTERED = ("auto", "yes", "no")


@dataclass(frozen=True, slots=True)
class PoseParams:
    """Where poses come from: ``none`` = odometry of our own, ``tf``, or a ``topic`` of ``type``.

    With ``tf`` the map is in ``world_frame``, with a topic in the frame its messages name. A pose
    without the name of what it is the pose of is that of ``camera_frame`` (of the colour images by
    default). A frame whose pose has not come ``wait_s`` after it (of the robot's time) is dropped.
    """

    kind: str = "none"
    world_frame: str = "map"
    camera_frame: str = ""
    topic: str = ""
    type: str = ODOMETRY
    wait_s: float = 1.0

    def __post_init__(self) -> None:
        if self.kind not in POSE_KINDS:
            raise ValueError(f"kind: expected one of {', '.join(POSE_KINDS)}, got {self.kind!r}")
        if self.type not in (ODOMETRY, POSE_STAMPED):
            raise ValueError(f"type: expected {ODOMETRY} or {POSE_STAMPED}, got {self.type!r}")
        if self.kind == "topic":
            topic_path(self.topic)
        need_at_least(self, 0, "wait_s")


@dataclass(frozen=True, slots=True)
class Ros2Params:
    """Topics of an RGB-D camera, or of a colour camera and a LiDAR, and how they are read.

    ``camera_info_topic`` and ``depth_info_topic`` lie beside the images by default.
    ``depth_registered`` yes: depth is in the colour camera whatever its frame is called; no: it is
    not; auto: it is if both frames are the same one. ``sync_tolerance_s`` seconds may lie between
    colour and depth of one frame; at most ``capacity`` of each wait. Something missing for
    ``patience_s`` seconds is said; so is a clock that jumps by ``clock_jump_s``. ``lidar_*`` count
    with ``points_topic`` alone: then the poses of our own are those of whole scans.
    """

    colour_topic: str
    depth_topic: str = ""
    points_topic: str = ""
    camera_info_topic: str = ""
    depth_info_topic: str = ""
    pose: PoseParams = field(default_factory=PoseParams)
    domain: int = 0
    dialect: str = "auto"
    distro: str = "jazzy"
    depth_registered: str = "auto"
    sync_tolerance_s: float = 0.02
    capacity: int = 16
    patience_s: float = 5.0
    clock_jump_s: float = 2.0
    lidar_odometry: LidarOdometryParams = field(default_factory=LidarOdometryParams)
    lidar_depth: LidarDepthParams = field(default_factory=LidarDepthParams)

    def __post_init__(self) -> None:
        if bool(self.depth_topic) == bool(self.points_topic):
            raise ValueError("depth_topic: say it or points_topic, one of the two")
        for topic in self._given_topics():
            topic_path(topic)
        for name, known in (
            ("dialect", DIALECTS),
            ("distro", tuple(DISTROS)),
            ("depth_registered", REGISTERED),
        ):
            if getattr(self, name) not in known:
                got = getattr(self, name)
                raise ValueError(f"{name}: expected one of {', '.join(known)}, got {got!r}")
        if not 0 <= self.domain <= 232:
            raise ValueError(f"domain: expected 0 to 232, got {self.domain}")
        need_at_least(self, 1, "capacity")
        need_positive(self, "sync_tolerance_s", "patience_s", "clock_jump_s")

    @property
    def has_poses(self) -> bool:
        """Tell whether frames come with poses: a robot's, or those of its LiDAR's scans."""
        return self.pose.kind != "none" or bool(self.points_topic)

    @property
    def colour_info(self) -> str:
        """The topic of the colour camera's calibration."""
        return self.camera_info_topic or info_topic(self.colour_topic)

    @property
    def depth_info(self) -> str:
        """The topic of the depth camera's calibration; empty without one."""
        return self.depth_info_topic or (info_topic(self.depth_topic) if self.depth_topic else "")

    @property
    def range_topic(self) -> str:
        """The topic that distances come on: depth images, or points."""
        return self.depth_topic or self.points_topic

    def _given_topics(self) -> list[str]:
        topics = (self.colour_topic, self.range_topic, self.camera_info_topic)
        return [topic for topic in (*topics, self.depth_info_topic) if topic]
