"""Node kind ``ros``: gives the map back to the robot as ROS 2 messages.

Reads   map and name deltas of the scene (state: gaps are healed by the snapshots).
Writes  on the ROS 2 keys of ``dialect``: <prefix>/detections (vision_msgs/Detection3DArray),
        <prefix>/markers (visualization_msgs/MarkerArray) and <prefix>/cloud
        (sensor_msgs/PointCloud2 with x y z rgb instance_id), in the frame ``frame_id``.
Rate    when the map or a name changed, ``rate_hz`` times a second at most, dropped when the link
        is full; again every ``repeat_s`` for those who came later.
Bad     a delta that contradicts the map is counted (``map_delta_bad``) and left out.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from sceneq_core.checks import need_at_least, need_positive
from sceneq_nodes._bus import Bus, Context, Received, foreign_keys
from sceneq_nodes._follow import Follower
from sceneq_nodes._followed_map import FollowedMap
from sceneq_nodes.ros.keys import DIALECTS, topic_path
from sceneq_nodes.ros.results import CLOUD, DETECTIONS, MARKERS, Name, Results, objects
from sceneq_nodes.ros.typestore import DISTROS, typestore
from sceneq_nodes.ros.writer import Writer
from sceneq_schemas import topics
from sceneq_schemas.label import LabelDelta
from sceneq_schemas.map import MapDelta

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class RosOutputParams:
    """Where ROS programs find the results, how often, and in which form of keys."""

    prefix: str = "/scene_q"
    frame_id: str = "map"
    domain: int = 0
    dialect: str = "jazzy"
    distro: str = "jazzy"
    rate_hz: float = 1.0
    repeat_s: float = 5.0
    max_points: int = 200_000

    def __post_init__(self) -> None:
        topic_path(self.prefix)
        for name, known in (("dialect", DIALECTS[1:]), ("distro", tuple(DISTROS))):
            if getattr(self, name) not in known:
                got = getattr(self, name)
                raise ValueError(f"{name}: expected one of {', '.join(known)}, got {got!r}")
        if not 0 <= self.domain <= 232:
            raise ValueError(f"domain: expected 0 to 232, got {self.domain}")
        need_positive(self, "rate_hz", "repeat_s")
        need_at_least(self, 1, "max_points")


def published_topics(prefix: str) -> dict[str, str]:
    """Return topic -> message type."""
    types = {"detections": DETECTIONS, "markers": MARKERS, "cloud": CLOUD}
    return {f"{prefix}/{name}": kind for name, kind in types.items()}


class RosOutput:
    """Follows one scene and publishes it."""

    Params: ClassVar[type] = RosOutputParams
    idle_s: ClassVar[float] = 0.1

    def __init__(
        self,
        params: RosOutputParams,
        context: Context,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._params = params
        self._context = context
        self._clock = clock
        self._names: dict[int, Name] = {}
        self._is_new = False
        self._sent_s = float("-inf")

    def open(self, bus: Bus) -> None:
        """Announce the publishers and listen to the map; ``ValueError`` without a network."""
        params, scene = self._params, self._context.scene
        self._bus = bus
        store = typestore(params.distro)
        self._results = Results(store, params.frame_id, params.max_points)
        published = published_topics(params.prefix)
        self._writer = Writer(foreign_keys(bus), store, published, params.domain, params.dialect)
        self._map = FollowedMap(bus, scene, self._note)
        self._labels = Follower(
            bus, topics.LABEL_DELTA, topics.LABEL_SNAPSHOT, self._rename, scene=scene
        )
        self._map.open()
        self._labels.open()

    def step(self, received: Received | None) -> None:
        """Take in what changed; publish when it is time."""
        if received is None:
            self._map.tick()
            self._labels.tick()
        elif received.topic is topics.MAP_DELTA:
            self._map.offer(received.message)
        else:
            self._labels.offer(received.message)
        since_s = self._clock() - self._sent_s
        wait_s = 1.0 / self._params.rate_hz if self._is_new else self._params.repeat_s
        if since_s >= wait_s and self._map.replica.frame_seq >= 0:
            self._publish()

    def close(self) -> None:
        """Nothing to release."""

    def _publish(self) -> None:
        prefix, results, replica = self._params.prefix, self._results, self._map.replica
        self._writer.publish(f"{prefix}/detections", results.detections(replica, self._names))
        self._writer.publish(f"{prefix}/markers", results.markers(replica, self._names))
        self._writer.publish(f"{prefix}/cloud", results.cloud(replica))
        self._sent_s, self._is_new = self._clock(), False
        self._bus.count("published")
        self._bus.report(objects=len(objects(replica)), names=len(self._names))

    def _note(self, _: MapDelta) -> None:
        self._is_new = True

    def _rename(self, delta: LabelDelta) -> None:
        """Take names that the gate let pass; an instance whose name it did not has none."""
        if delta.full:
            self._names = {}
        for key in delta.removed.tolist():
            self._names.pop(key, None)
        for label in delta.labels:
            if label.accepted:
                self._names[label.instance_id] = Name(label.name, label.p)
            else:
                self._names.pop(label.instance_id, None)
        self._is_new = True
