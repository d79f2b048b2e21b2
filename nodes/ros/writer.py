"""Publishes messages so that ROS 2 programs find and take them."""

import hashlib
import time
from collections.abc import Callable, Mapping
from typing import Any

from sceneq_nodes._bus import ForeignKeys
from sceneq_nodes.ros.keys import (
    GID_BYTES,
    NO_HASH,
    Attachment,
    data_key,
    node_token,
    pack_attachment,
    publisher_token,
)
from sceneq_nodes.ros.typestore import Typestore

NODE = "sceneq"


class Writer:
    """The publishers of one ROS node; ``topics`` are topic -> message type.

    In the dialects of rmw_zenoh each holds the liveliness token by which ``ros2 topic list`` finds
    it, and messages carry the attachment without which they would be dropped. The bridge needs
    neither.
    """

    def __init__(
        self,
        keys: ForeignKeys,
        store: Typestore,
        topics: Mapping[str, str],
        domain: int,
        dialect: str,
        clock_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._keys, self._store, self._types = keys, store, dict(topics)
        self._domain, self._dialect, self._clock_ns = domain, dialect, clock_ns
        self._sent = dict.fromkeys(topics, 0)
        self._gids = {}
        self._is_bridge = dialect == "bridge"
        if not self._is_bridge:
            keys.hold(node_token(domain, keys.session_id, NODE))
        for number, (topic, type_name) in enumerate(topics.items(), 1):
            typed = (type_name, self._hash(type_name))
            token = publisher_token(domain, keys.session_id, number, NODE, topic, typed)
            self._gids[topic] = hashlib.blake2b(token.encode(), digest_size=GID_BYTES).digest()
            if not self._is_bridge:
                keys.hold(token)

    def publish(self, topic: str, message: Any) -> None:
        """Send ``message`` on one of the topics."""
        type_name = self._types[topic]
        key = data_key(topic, type_name, self._hash(type_name), self._domain, self._dialect)
        self._sent[topic] += 1
        attachment = Attachment(self._sent[topic], self._clock_ns(), self._gids[topic])
        data = self._store.encode(type_name, message)
        self._keys.publish(key, data, b"" if self._is_bridge else pack_attachment(attachment))

    def _hash(self, type_name: str) -> str:
        return NO_HASH if self._dialect == "humble" else self._store.hash(type_name)
