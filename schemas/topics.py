"""The one table of keys: who writes what, where, how it is delivered and how often."""

import re
from dataclasses import dataclass
from enum import Enum

from sceneq_schemas.correction import PoseCorrection
from sceneq_schemas.feature import FeatureDelta
from sceneq_schemas.frame import Frame, Pose
from sceneq_schemas.label import LabelDelta
from sceneq_schemas.map import MapDelta, MapDeltas
from sceneq_schemas.mask import Masks
from sceneq_schemas.place import PlaceSet
from sceneq_schemas.proposal import ProposalSet
from sceneq_schemas.view import ViewDelta

ID = re.compile(r"[a-z0-9_-]+")
MIB = 1024 * 1024

_PLACE = re.compile(r"\{(\w+)\}")


class Delivery(Enum):
    """How a topic travels. No class blocks its writer."""

    LATEST = "latest wins: dropped when the reader is slow, the newest are kept"
    STATE = "epoch and seq in every message: a gap is seen and healed from the snapshot"
    QUERY = "request and reply, interactive priority, express"
    BULK = "request and reply of much data, in pages if asked so, at the priority of frames"
    BACKGROUND = "small and periodic, lowest priority"
    LIVELINESS = "token that exists as long as the process"


@dataclass(frozen=True, slots=True)
class Topic:
    """A key pattern such as ``sceneq/mask/{scene}/v1`` with the type and delivery of its data.

    Data are the msgpack of ``message``; without one, of ``media_type``.
    """

    name: str
    pattern: str
    writer: str
    delivery: Delivery
    rate_hz: float
    max_bytes: int
    message: type | None = None
    media_type: str = "application/json"

    @property
    def encoding(self) -> str:
        """The zenoh encoding; of data of ours it names the schema."""
        if self.media_type != "application/json":
            return self.media_type
        if self.message is None:
            return f"application/json;sceneq.{self.name}.v1"
        return f"application/msgpack;{self.message.SCHEMA}"  # type: ignore[attr-defined]

    @property
    def id_names(self) -> tuple[str, ...]:
        """The names of the ids in the pattern, such as ``("robot", "sensor")``."""
        return tuple(_PLACE.findall(self.pattern))

    def key(self, **ids: str) -> str:
        """Return the concrete key.

        Raises:
            ValueError: an id outside ``[a-z0-9_-]+``, one too few or one too many.
        """
        if set(ids) != set(self.id_names):
            want, got = ", ".join(self.id_names), ", ".join(sorted(ids))
            raise ValueError(f"{self.name}: expected the ids {want}, got {got or 'none'}")
        return self.selector(**ids)

    def selector(self, **ids: str) -> str:
        """Return the key with ``*`` for every id not given; raise ``ValueError`` as ``key``."""
        for name, value in ids.items():
            if name not in self.id_names:
                raise ValueError(f"{self.name}: no id {name} in {self.pattern}")
            if not ID.fullmatch(value):
                raise ValueError(f"{self.name}: {name} {value!r} must match {ID.pattern}")
        return self.pattern.format_map(_Wild(ids))

    def ids(self, key: str) -> dict[str, str] | None:
        """Return the ids in a concrete key, or ``None`` when the key is not of this topic."""
        chunks, wanted = key.split("/"), self.pattern.split("/")
        if len(chunks) != len(wanted):
            return None
        ids = {}
        for chunk, want in zip(chunks, wanted, strict=True):
            if place := _PLACE.fullmatch(want):
                ids[place[1]] = chunk
            elif chunk != want:
                return None
        return ids if all(ID.fullmatch(value) for value in ids.values()) else None


class _Wild(dict[str, str]):
    def __missing__(self, name: str) -> str:
        return "*"


_L, _S, _Q, _B = Delivery.LATEST, Delivery.STATE, Delivery.QUERY, Delivery.BACKGROUND
_P = Delivery.BULK

FRAME = Topic("frame", "sceneq/frame/{robot}/{sensor}/v1", "ingest", _L, 3, 32 * MIB, Frame)
POSE = Topic("pose", "sceneq/pose/{robot}/v1", "ingest", _L, 30, 4096, Pose)
POSE_CORRECTION = Topic(
    "correction", "sceneq/pose/{robot}/correction/v1", "ingest", _S, 0.1, 16 * MIB, PoseCorrection
)
MASK = Topic("mask", "sceneq/mask/{scene}/v1", "segmentation", _L, 3, 32 * MIB, Masks)
PROPOSAL = Topic(
    "proposal", "sceneq/proposal/{scene}/v1", "a 3D network", _L, 0.1, 64 * MIB, ProposalSet
)
MAP_DELTA = Topic("map_delta", "sceneq/map/{scene}/delta/v1", "mapping", _S, 3, 64 * MIB, MapDelta)
MAP_SNAPSHOT = Topic(
    "map_snapshot", "sceneq/map/{scene}/@snapshot/v1", "mapping", _P, 0, 256 * MIB, MapDelta
)
MAP_JOURNAL = Topic(
    "map_journal", "sceneq/map/{scene}/@journal/v1", "mapping", _P, 0, 256 * MIB, MapDeltas
)
PLACES = Topic("places", "sceneq/map/{scene}/@places/v1", "mapping", _P, 0, 128 * MIB, PlaceSet)
VISIT = Topic("visit", "sceneq/visit/{scene}", "mapping", _Q, 0, 64 * 1024)
VIEW_DELTA = Topic(
    "view_delta", "sceneq/view/{scene}/delta/v1", "views", _S, 3, 32 * MIB, ViewDelta
)
VIEW_SNAPSHOT = Topic(
    "view_snapshot", "sceneq/view/{scene}/@snapshot/v1", "views", _P, 0, 64 * MIB, ViewDelta
)
VIEW_JOURNAL = Topic(
    "view_journal", "sceneq/view/{scene}/@journal/v1", "views", _P, 0, 64 * MIB, ViewDelta
)
VIEW_IMAGE = Topic(
    "view_image", "sceneq/view/{scene}/@image/v1", "views", _P, 0, 8 * MIB, media_type="image/jpeg"
)
FEATURE_DELTA = Topic(
    "feature_delta",
    "sceneq/feat/{scene}/{model}/delta/v1",
    "encoding",
    _S,
    3,
    32 * MIB,
    FeatureDelta,
)
FEATURE_SNAPSHOT = Topic(
    "feature_snapshot",
    "sceneq/feat/{scene}/{model}/@snapshot/v1",
    "encoding",
    _P,
    0,
    64 * MIB,
    FeatureDelta,
)
FEATURE_JOURNAL = Topic(
    "feature_journal",
    "sceneq/feat/{scene}/{model}/@journal/v1",
    "encoding",
    _P,
    0,
    64 * MIB,
    FeatureDelta,
)
LABEL_DELTA = Topic(
    "label_delta", "sceneq/label/{scene}/delta/v1", "routing", _S, 2, 32 * MIB, LabelDelta
)
LABEL_SNAPSHOT = Topic(
    "label_snapshot", "sceneq/label/{scene}/@snapshot/v1", "routing", _P, 0, 64 * MIB, LabelDelta
)
REASON = Topic("reason", "sceneq/reason/{scene}/v1", "reasoning", _Q, 0, MIB)
QUERY_INSTANCES = Topic("answer", "sceneq/query/{scene}/instances", "routing", _Q, 0, MIB)
QUERY_ASK = Topic("answer", "sceneq/query/{scene}/ask", "routing", _Q, 0, MIB)
QUERY_LABEL = Topic("label", "sceneq/query/{scene}/label", "routing", _Q, 0, MIB)
QUERY_STATUS = Topic("status", "sceneq/query/{scene}/status", "routing", _Q, 0, MIB)
QUERY_LABELS = Topic("labels", "sceneq/query/{scene}/labels", "routing", _Q, 0, MIB)
QUERY_LAST = Topic("last", "sceneq/query/{scene}/last", "routing", _Q, 0, MIB)
QUERY_NAMES = Topic("names", "sceneq/query/{scene}/names", "routing", _Q, 0, MIB)
TEACH_SET = Topic("taught", "sceneq/teach/{scene}/set", "routing", _Q, 0, MIB)
TEACH_FORGET = Topic("forgotten", "sceneq/teach/{scene}/forget", "routing", _Q, 0, MIB)
HEALTH = Topic("health", "sceneq/health/{node}", "every node", _B, 1, 64 * 1024)
METRIC = Topic("metric", "sceneq/metric/{node}", "every node", _B, 1, 64 * 1024)
CONTROL = Topic("control", "sceneq/ctl/{node}/{verb}", "every node", _Q, 0, 64 * 1024)
LIVE = Topic("live", "sceneq/@live/{node}/{id}", "every node", Delivery.LIVELINESS, 0, 0)

TOPICS = (
    FRAME,
    POSE,
    POSE_CORRECTION,
    MASK,
    PROPOSAL,
    MAP_DELTA,
    MAP_SNAPSHOT,
    MAP_JOURNAL,
    PLACES,
    VISIT,
    VIEW_DELTA,
    VIEW_SNAPSHOT,
    VIEW_JOURNAL,
    VIEW_IMAGE,
    FEATURE_DELTA,
    FEATURE_SNAPSHOT,
    FEATURE_JOURNAL,
    LABEL_DELTA,
    LABEL_SNAPSHOT,
    REASON,
    QUERY_INSTANCES,
    QUERY_ASK,
    QUERY_LABEL,
    QUERY_STATUS,
    QUERY_LABELS,
    QUERY_LAST,
    QUERY_NAMES,
    TEACH_SET,
    TEACH_FORGET,
    HEALTH,
    METRIC,
    CONTROL,
    LIVE,
)
