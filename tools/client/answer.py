"""Answers as typed values; ``raw`` keeps everything that came, also what is newer than this file.

Coordinates are metres in the scene's frame; times are capture times in nanoseconds.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

Json = Mapping[str, Any]
Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Box:
    """A box along the axes: its corner with the smallest and with the largest coordinates."""

    low_world: Point
    high_world: Point

    @property
    def size_m(self) -> Point:
        """Its edges."""
        x, y, z = (high - low for low, high in zip(self.low_world, self.high_world, strict=True))
        return (x, y, z)


@dataclass(frozen=True, slots=True)
class View:
    """A keyframe in which an instance is seen, inside ``box_xyxy`` in pixels.

    ``SceneQ.picture`` fetches it.
    """

    seq: int
    box_xyxy: tuple[float, float, float, float]
    key: str


@dataclass(frozen=True, slots=True)
class Instance:
    """One thing in the map; ``p`` is how probably it is what was asked for."""

    id: int
    label: str
    p: float
    state: str
    role: str
    centre_world: Point
    box: Box
    first_seen_ns: int
    last_seen_ns: int
    views: tuple[View, ...]
    raw: Json = field(repr=False, compare=False)

    @classmethod
    def read(cls, raw: Json) -> "Instance":
        """Return the instance in an answer; raise ``KeyError`` or ``TypeError`` if it is none."""
        box = raw["box_aabb"]
        return cls(
            id=raw["id"],
            label=raw["label"],
            p=raw["p"],
            state=raw["state"],
            role=raw["role"],
            centre_world=_point(raw["centre"]),
            box=Box(_point(box["min"]), _point(box["max"])),
            first_seen_ns=raw["first_seen_ns"],
            last_seen_ns=raw["last_seen_ns"],
            views=tuple(View(v["seq"], tuple(v["box_xyxy"]), v["key"]) for v in raw["views"]),
            raw=raw,
        )


@dataclass(frozen=True, slots=True)
class Confidence:
    """How sure an answer is: the gate's three measures at temperature ``T``."""

    p_max: float
    margin: float
    entropy_norm: float
    T: float

    @classmethod
    def read(cls, raw: Json) -> "Confidence":
        """Return the confidence in an answer."""
        return cls(raw["p_max"], raw["margin"], raw["entropy_norm"], raw["T"])


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to a question, best instance first.

    ``status`` is ``found``, ``ambiguous`` (which one?) or ``not_found``; ``said`` a sentence;
    ``route`` ``fast``, ``reasoned`` or ``fallback``, and ``reason`` why.
    """

    status: str
    question: str
    said: str
    instances: tuple[Instance, ...]
    confidence: Confidence
    route: str
    reason: str
    raw: Json = field(repr=False, compare=False)

    @classmethod
    def read(cls, raw: Json) -> "Answer":
        """Return the answer in a reply; raise ``KeyError`` or ``TypeError`` if it is none."""
        return cls(
            status=raw["status"],
            question=raw["question"],
            said=raw.get("said", ""),
            instances=tuple(Instance.read(one) for one in raw["instances"]),
            confidence=Confidence.read(raw["confidence"]),
            route=raw["route"],
            reason=raw["reason"],
            raw=raw,
        )

    @property
    def found(self) -> bool:
        """Whether the map has the thing and the scene is sure which one it is."""
        return self.status == "found"

    @property
    def best(self) -> Instance | None:
        """The likeliest instance; ``None`` when the thing is not there."""
        return self.instances[0] if self.instances and self.status != "not_found" else None


@dataclass(frozen=True, slots=True)
class Name:
    """One thing an instance may be called; ``source`` is encoder, reasoner, taught, inherited."""

    label: str
    p: float
    source: str


@dataclass(frozen=True, slots=True)
class Naming:
    """What an instance is called, likeliest first."""

    status: str
    instance: Instance
    names: tuple[Name, ...]
    route: str
    raw: Json = field(repr=False, compare=False)

    @classmethod
    def read(cls, raw: Json) -> "Naming":
        """Return the naming in a reply; raise ``KeyError`` or ``TypeError`` if it is none."""
        return cls(
            status=raw["status"],
            instance=Instance.read({"p": 1.0, **raw["instance"]}),
            names=tuple(Name(one["label"], one["p"], one["source"]) for one in raw["labels"]),
            route=raw["route"],
            raw=raw,
        )


def _point(raw: Any) -> Point:
    x, y, z = raw
    return (float(x), float(y), float(z))
