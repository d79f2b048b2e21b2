"""What every role may do on the bus, from the table of keys; everything else is denied."""

from collections.abc import Iterable
from dataclasses import dataclass

from sceneq_nodes.ros.passage import RosKeys
from sceneq_schemas.topics import (
    CONTROL,
    LIVE,
    TEACH_FORGET,
    TEACH_SET,
    TOPICS,
    Delivery,
    Topic,
)

ROUTER, ROBOT, SERVER, VIEWER, CLIENT, OPERATOR, ROS = (
    *("router", "robot", "server", "viewer", "client", "operator", "ros"),
)
ROLES = {
    ROUTER: "a machine's router: passes on what the others may do",
    ROBOT: "the nodes on a robot: everything but commands to other nodes",
    SERVER: "the nodes on a server: as a robot",
    OPERATOR: "a person in charge: sees, asks, names things and commands nodes",
    VIEWER: "sees the map, its pictures and the health of the nodes, and asks",
    CLIENT: "asks, and nothing else",
    ROS: "a robot's ROS 2: publishes the topics that graph.yaml reads, and hears the results",
}
OF_ONE_SCENE = (VIEWER, CLIENT)
"""Roles that may be given for one scene only."""
NO_ROS = RosKeys()
TEACHING = (TEACH_SET, TEACH_FORGET)
QUESTIONS = "sceneq/query/{scene}/**"
ANY_SCENE = "sceneq/query/**"

PUT = ("put", "delete")
LIVELINESS_WANTED = ("liveliness_query", "declare_liveliness_subscriber")
LIVELINESS = ("liveliness_token", *LIVELINESS_WANTED)
CACHE_SERVED = ("declare_queryable", "reply", "liveliness_token")
CACHE_WANTED = ("query", *LIVELINESS_WANTED)
EVERYTHING = (
    *(*PUT, "declare_subscriber", "query", "declare_queryable", "reply"),
    *LIVELINESS,
)


@dataclass(frozen=True, slots=True)
class Grant:
    """``messages`` may pass on ``keys``: into the router (``ingress``), out of it (``egress``)."""

    messages: tuple[str, ...]
    flows: tuple[str, ...]
    keys: tuple[str, ...]


def grants(role: str, scene: str | None = None, ros: RosKeys = NO_ROS) -> tuple[Grant, ...]:
    """Return what ``role`` may do, in one ``scene`` or in all; ``ros``: the ROS 2 keys let through.

    Raises:
        ValueError: no such role, or one that is not given for a single scene.
    """
    if role not in ROLES:
        raise ValueError(f"role {role!r}: expected one of {', '.join(ROLES)}")
    if scene is not None and role not in OF_ONE_SCENE:
        raise ValueError(
            f"role {role!r} is not given for one scene ({', '.join(OF_ONE_SCENE)} are)"
        )
    if role == ROS:
        return _ros_side(ros)
    if role == ROUTER:
        return (_all_of(TOPICS), *_passes(ros))
    if role in (ROBOT, SERVER):
        ours = _all_of(topic for topic in TOPICS if topic is not CONTROL)
        return (ours, *_serves(CONTROL), *_our_side(ros))
    asking = _asks((QUESTIONS.format(scene=scene) if scene else ANY_SCENE,))
    if role == CLIENT:
        return asking
    watching = (*asking, *_watches(scene))
    if role == VIEWER:
        return watching
    return (*watching, *_asks([topic.selector() for topic in (*TEACHING, CONTROL)]))


def _all_of(topics: Iterable[Topic]) -> Grant:
    keys = (*(topic.selector() for topic in topics), ANY_SCENE)
    return Grant(EVERYTHING, ("ingress", "egress"), keys)


def _ros_side(ros: RosKeys) -> tuple[Grant, ...]:
    """Say what is read of it, and keep what is latched; hear the results."""
    return (*_says(ros.read), *_keeps(ros.latched), *_hears(ros.written), *_finds(ros.tokens))


def _our_side(ros: RosKeys) -> tuple[Grant, ...]:
    """Hear what is read, with what was said before; say the results."""
    return (*_hears(ros.read), *_fetches(ros.latched), *_says(ros.written), *_tells(ros.tokens))


def _passes(ros: RosKeys) -> tuple[Grant, ...]:
    keys = (*ros.read, *_caches(ros.latched), *ros.written, *ros.tokens)
    return (Grant(EVERYTHING, ("ingress", "egress"), keys),) if keys else ()


def _says(keys: tuple[str, ...]) -> tuple[Grant, ...]:
    return _both_ways(PUT, ("declare_subscriber",), keys)


def _hears(keys: tuple[str, ...]) -> tuple[Grant, ...]:
    return _both_ways(("declare_subscriber",), PUT, keys)


def _keeps(keys: tuple[str, ...]) -> tuple[Grant, ...]:
    """Answer for what was said before, and tell that one does by a token."""
    served = _both_ways(CACHE_SERVED, CACHE_WANTED, _caches(keys))
    return (*served, Grant(("reply",), ("ingress",), keys)) if keys else ()


def _fetches(keys: tuple[str, ...]) -> tuple[Grant, ...]:
    asked = _both_ways(CACHE_WANTED, CACHE_SERVED, _caches(keys))
    return (*asked, Grant(("reply",), ("egress",), keys)) if keys else ()


def _caches(keys: tuple[str, ...]) -> tuple[str, ...]:
    """Return where zenoh's advanced publishers are asked for data; replies have the data's key."""
    return tuple(f"{key}/@adv/**" for key in keys)


def _tells(keys: tuple[str, ...]) -> tuple[Grant, ...]:
    return _both_ways(("liveliness_token",), LIVELINESS_WANTED, keys)


def _finds(keys: tuple[str, ...]) -> tuple[Grant, ...]:
    return _both_ways(LIVELINESS_WANTED, ("liveliness_token",), keys)


def _both_ways(
    into: tuple[str, ...], out: tuple[str, ...], keys: tuple[str, ...]
) -> tuple[Grant, ...]:
    """Return what may come into the router and what may go out; nothing where there are no keys."""
    return (Grant(into, ("ingress",), keys), Grant(out, ("egress",), keys)) if keys else ()


def _serves(topic: Topic) -> tuple[Grant, ...]:
    keys = (topic.selector(),)
    return (
        Grant(("declare_queryable", "reply"), ("ingress",), keys),
        Grant(("query",), ("egress",), keys),
    )


def _asks(keys: Iterable[str]) -> tuple[Grant, ...]:
    keys = tuple(keys)
    return Grant(("query",), ("ingress",), keys), Grant(("reply",), ("egress",), keys)


def _watches(scene: str | None) -> tuple[Grant, ...]:
    """See what is published, and the snapshots and pictures behind it; of one scene or of all."""
    published = [t for t in TOPICS if t.delivery in (Delivery.STATE, Delivery.LATEST)]
    heard = [*published, *(t for t in TOPICS if t.delivery is Delivery.BACKGROUND)]
    asked = [t for t in TOPICS if "/@" in t.pattern and t is not LIVE]
    if scene is not None:
        heard, asked = ([t for t in some if "scene" in t.id_names] for some in (heard, asked))
    keys = tuple(_of(topic, scene) for topic in heard)
    live = (
        () if scene is not None else (Grant(LIVELINESS, ("ingress", "egress"), (LIVE.selector(),)),)
    )
    return (
        Grant(("declare_subscriber",), ("ingress",), keys),
        Grant(PUT, ("egress",), keys),
        *_asks(_of(topic, scene) for topic in asked),
        *live,
    )


def _of(topic: Topic, scene: str | None) -> str:
    return topic.selector(scene=scene) if scene is not None else topic.selector()
