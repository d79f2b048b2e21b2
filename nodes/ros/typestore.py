"""ROS 2 messages as bytes and back, and the hashes of their types, with ``rosbags``."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

DISTROS = {
    "humble": Stores.ROS2_HUMBLE,
    "jazzy": Stores.ROS2_JAZZY,
    "kilted": Stores.ROS2_KILTED,
}
VISION_MSGS = {
    "ObjectHypothesis": "string class_id\nfloat64 score\n",
    "ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis\ngeometry_msgs/PoseWithCovariance pose\n"
    ),
    "BoundingBox3D": "geometry_msgs/Pose center\ngeometry_msgs/Vector3 size\n",
    "Detection3D": (
        "std_msgs/Header header\nvision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox3D bbox\nstring id\n"
    ),
    "Detection3DArray": "std_msgs/Header header\nvision_msgs/Detection3D[] detections\n",
}
"""Fields of the messages of the package ``vision_msgs`` 4 (Humble to Kilted)."""


class WireError(ValueError):
    """Bytes or a key that are not what they should be."""


class Typestore:
    """The messages of one distribution of ROS 2, ``vision_msgs`` among them."""

    def __init__(self, distro: str) -> None:
        """Raise ``ValueError`` for an unknown distribution."""
        if distro not in DISTROS:
            raise ValueError(f"distro: expected one of {', '.join(DISTROS)}, got {distro!r}")
        self._store = get_typestore(DISTROS[distro])
        for name, fields in VISION_MSGS.items():
            self._store.register(get_types_from_msg(fields, f"vision_msgs/msg/{name}"))

    def knows(self, type_name: str) -> bool:
        """Tell whether ``sensor_msgs/msg/Image`` or the like is one of its types."""
        return type_name in self._store.fielddefs

    def decode(self, type_name: str, data: bytes) -> Any:
        """Return the message in CDR ``data``; arrays are views of it. ``WireError`` if it is none.

        Of bytes from elsewhere anything may come, so any error of the decoder means: not one.
        """
        if not self.knows(type_name):
            raise WireError(f"unknown message type {type_name}")
        try:
            return self._store.deserialize_cdr(data, type_name)
        except Exception as error:
            raise WireError(f"{len(data)} bytes are no {type_name}: {error!r:.120}") from error

    def encode(self, type_name: str, message: Any) -> bytes:
        """Return ``message`` as little-endian CDR."""
        return bytes(self._store.serialize_cdr(message, type_name))

    def hash(self, type_name: str) -> str:
        """Return the hash of the type as REP 2011 defines it: ``RIHS01_`` and 64 digits."""
        return str(self._store.hash_rihs01(type_name))

    def make(self, type_name: str, **fields: Any) -> Any:
        """Return a new message of a type."""
        return self._store.types[type_name](**fields)

    @property
    def types(self) -> Mapping[str, type]:
        """Message type name -> class."""
        return self._store.types


@cache
def typestore(distro: str) -> Typestore:
    """Return the one store of a distribution: to make it takes tens of milliseconds."""
    return Typestore(distro)
