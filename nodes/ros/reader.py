"""From samples on ROS 2 keys to decoded messages: one topic, one role."""

from dataclasses import dataclass
from typing import Any

from sceneq_nodes._bus import ForeignSample
from sceneq_nodes.ros.keys import NO_HASH, parse_key
from sceneq_nodes.ros.troubles import Troubles
from sceneq_nodes.ros.typestore import Typestore, WireError

IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
CAMERA_INFO, POINTS = "sensor_msgs/msg/CameraInfo", "sensor_msgs/msg/PointCloud2"
TF_MESSAGE = "tf2_msgs/msg/TFMessage"
COMPRESSED_NAMES = ("compressed", "compressedDepth")


@dataclass(frozen=True, slots=True)
class TopicRole:
    """What a topic is for, and the message types that serve it, the likeliest first."""

    role: str
    topic: str
    types: tuple[str, ...]
    latched: bool = False


def image_role(role: str, topic: str) -> TopicRole:
    """Return the role of an image topic; image_transport says by the name what is compressed."""
    types = (IMAGE, COMPRESSED)
    is_compressed = topic.rpartition("/")[2] in COMPRESSED_NAMES
    return TopicRole(role, topic, types[::-1] if is_compressed else types)


class Reader:
    """Decodes what comes on one topic; what cannot be decoded is a trouble."""

    def __init__(self, topic: TopicRole, store: Typestore, troubles: Troubles) -> None:
        self.role = topic.role
        self._topic = topic
        self._store = store
        self._troubles = troubles
        self._hashes = {name: store.hash(name) for name in topic.types}

    def read(self, sample: ForeignSample) -> Any | None:
        """Return the message, or ``None`` after having said why not."""
        topic = self._topic.topic
        try:
            key = parse_key(sample.key, topic)
            type_name = key.type_name or self._topic.types[0]
            if wrong := self._wrong_type(type_name, key.type_hash):
                self._troubles.lasts(self._kind, f"{topic} {wrong}")
                return None
            message = self._store.decode(type_name, sample.payload)
        except WireError as error:
            self._troubles.note("undecodable", f"{topic}: {error}")
            return None
        self._troubles.over(self._kind)
        return message

    @property
    def _kind(self) -> str:
        return f"wrong_type_{self.role}"

    def _wrong_type(self, type_name: str, type_hash: str) -> str:
        """Return what is wrong with the type, empty when nothing is."""
        if type_name not in self._hashes:
            return f"carries {type_name}, expected {' or '.join(self._hashes)}"
        ours = self._hashes[type_name]
        if type_hash in ("", NO_HASH, ours):
            return ""
        return (
            f"carries {type_name} with hash {type_hash:.20}..., ours is {ours:.20}...: another "
            "version of the message (distro)"
        )
