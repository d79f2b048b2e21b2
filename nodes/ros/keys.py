"""The Zenoh keys of ROS 2 topics: rmw_zenoh's of Jazzy and Humble, and zenoh-bridge-ros2dds's.

rmw_zenoh: ``<domain>/<topic>/<pkg>::msg::dds_::<Type>_/<hash>``, in Humble with
``TypeHashNotSupported`` for the hash (rmw_zenoh, docs/design.md). The bridge: the topic alone.
"""

import re
import struct
from dataclasses import dataclass

from sceneq_nodes.ros.typestore import WireError

DIALECTS = ("auto", "jazzy", "humble", "bridge")
NO_HASH = "TypeHashNotSupported"
DDS_TYPE = re.compile(r"(\w+)::(msg)::dds_::(\w+)_")
TOPIC = re.compile(r"/?[A-Za-z_~][\w]*(/[A-Za-z_]\w*)*")
GID_BYTES = 16
ATTACHMENT = struct.Struct(f"<qqB{GID_BYTES}s")


@dataclass(frozen=True, slots=True)
class DataKey:
    """What a key says of its data; empty where the dialect does not say it."""

    topic: str
    type_name: str = ""
    type_hash: str = ""


@dataclass(frozen=True, slots=True)
class Attachment:
    """What rmw_zenoh sends with every message: number from 1, source stamp, and the writer."""

    seq: int
    stamp_ns: int
    gid: bytes


def topic_path(topic: str) -> str:
    """Return the topic as part of a key: without the first slash.

    Raises:
        ValueError: not the name of a topic.
    """
    if not TOPIC.fullmatch(topic):
        raise ValueError(f"{topic!r} is no topic, such as /camera/color/image_raw")
    return topic.strip("/")


def selectors(topic: str, domain: int, dialect: str) -> list[str]:
    """Return the key expressions that data of ``topic`` come on."""
    path = topic_path(topic)
    rmw = f"{domain}/{path}/*/*"
    return {"auto": [rmw, path], "bridge": [path]}.get(dialect, [rmw])


def data_key(topic: str, type_name: str, type_hash: str, domain: int, dialect: str) -> str:
    """Return the key to publish ``topic`` on; of a type such as ``sensor_msgs/msg/Image``."""
    path = topic_path(topic)
    if dialect == "bridge":
        return path
    return f"{domain}/{path}/{dds_type(type_name)}/{type_hash}"


def parse_key(key: str, topic: str) -> DataKey:
    """Return what ``key``, which came on one of the selectors of ``topic``, says."""
    path = topic_path(topic)
    if key == path:
        return DataKey(topic)
    dds, type_hash = key.split("/")[-2:]
    found = DDS_TYPE.fullmatch(dds)
    if found is None:
        raise WireError(f"{key}: {dds!r} is no type, such as sensor_msgs::msg::dds_::Image_")
    return DataKey(topic, "/".join(found.groups()), type_hash)


def dds_type(type_name: str) -> str:
    """Return ``sensor_msgs::msg::dds_::Image_`` for ``sensor_msgs/msg/Image``."""
    package, kind, name = type_name.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def pack_attachment(attachment: Attachment) -> bytes:
    """Return the 33 bytes without which rmw_zenoh drops a message."""
    return ATTACHMENT.pack(attachment.seq, attachment.stamp_ns, GID_BYTES, attachment.gid)


def unpack_attachment(data: bytes) -> Attachment:
    """Return what was attached; ``WireError`` when it is nothing of rmw_zenoh's."""
    if len(data) != ATTACHMENT.size:
        raise WireError(f"attachment of {len(data)} bytes, rmw_zenoh's has {ATTACHMENT.size}")
    seq, stamp_ns, length, gid = ATTACHMENT.unpack(data)
    if length != GID_BYTES:
        raise WireError(f"attachment with a gid of {length} bytes, expected {GID_BYTES}")
    return Attachment(seq, stamp_ns, gid)


def mangled(name: str) -> str:
    """Return a ROS name as one chunk of a key; of an empty one ``%``."""
    return name.replace("/", "%") or "%"


def node_token(domain: int, session_id: str, node: str) -> str:
    """Return the liveliness token by which ``ros2 node list`` finds a node."""
    return f"@ros2_lv/{domain}/{session_id}/0/0/NN/%/%/{node}"


def publisher_token(
    domain: int, session_id: str, number: int, node: str, topic: str, typed: tuple[str, str]
) -> str:
    """Return the liveliness token by which ``ros2 topic list`` finds a publisher.

    ``number`` is that of the entity in its node, ``typed`` its type and hash; its QoS is the
    default one: reliable, volatile, keep the last 10.
    """
    type_name, type_hash = typed
    path = mangled("/" + topic_path(topic))
    entity = f"{domain}/{session_id}/0/{number}/MP/%/%/{node}"
    return f"@ros2_lv/{entity}/{path}/{dds_type(type_name)}/{type_hash}/::,10:,:,:,,"
