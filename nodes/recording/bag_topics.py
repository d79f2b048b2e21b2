"""Which topics of a bag are the camera's, and where its poses come from, by type and name."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from sceneq_nodes.ros.camera_info import info_topic
from sceneq_nodes.ros.params import ODOMETRY, POSE_STAMPED, PoseParams
from sceneq_nodes.ros.reader import CAMERA_INFO, COMPRESSED, IMAGE, TF_MESSAGE
from sceneq_nodes.ros.stamped_poses import frame_name

TF_STATIC = "tf_static"
TF_TYPES = (TF_MESSAGE, "tf/msg/tfMessage")
"""The second is that of old ROS 1."""
OTHER_EYES = ("infra", "stereo", "left", "right", "fisheye", "mask", "label", "segment")
ALIGNED = ("aligned", "registered", "rect_to")


@dataclass(frozen=True, slots=True)
class Names:
    """Topics as the user gave them, empty where the bag shall say."""

    colour: str
    depth: str
    colour_info: str
    depth_info: str


def camera_topics(given: Names, types: Mapping[str, str]) -> Names:
    """Return all topics of the camera; ``types``: topic -> message type of all in the bag.

    Raises:
        ValueError: none of a kind, or several that nothing tells apart; names them.
    """
    images = {topic: kind for topic, kind in types.items() if kind in (IMAGE, COMPRESSED)}
    infos = [topic for topic, kind in types.items() if kind == CAMERA_INFO]
    depths = [topic for topic in images if _is_depth(topic)]
    colours = [topic for topic in images if _is_colour(topic)]
    depth = given.depth or _one("depth", _preferred(depths, infos, ALIGNED), images)
    colour = given.colour or _one("colour", _preferred(colours, infos, ("color", "rgb")), images)
    return Names(
        colour,
        depth,
        given.colour_info or info_topic(colour),
        given.depth_info or info_topic(depth),
    )


def pose_of(types: Mapping[str, str], transforms: Iterable[Any], camera: str) -> PoseParams:
    """Return where poses come from: tf if it moves ``camera``, else the one topic of poses.

    ``transforms``: the TransformStamped of the bag's beginning, with whether they are static.
    """
    above: dict[str, str] = {}
    moving: set[str] = set()
    for stamped, is_static in transforms:
        child = frame_name(stamped.child_frame_id)
        above[child] = frame_name(stamped.header.frame_id)
        if not is_static:
            moving.add(child)
    frame, moves = frame_name(camera), False
    for _ in range(len(above)):
        moves, frame = moves or frame in moving, above.get(frame, frame)
    if moves:
        return PoseParams("tf", world_frame=frame)
    told = [(topic, kind) for topic, kind in types.items() if kind in (ODOMETRY, POSE_STAMPED)]
    if len(told) == 1:
        return PoseParams("topic", topic=told[0][0], type=told[0][1])
    return PoseParams("none")


def is_tf(topic: str, kind: str) -> bool:
    """Tell the topics of tf, whoever remapped them."""
    return kind in TF_TYPES and topic.rpartition("/")[2] in ("tf", TF_STATIC)


def _is_depth(topic: str) -> bool:
    return "depth" in topic.lower() and not topic.endswith("/compressed")


def _is_colour(topic: str) -> bool:
    name = topic.lower()
    return "depth" not in name and not any(word in name for word in OTHER_EYES)


def _preferred(topics: list[str], infos: list[str], words: tuple[str, ...]) -> list[str]:
    """Return the best of ``topics``: calibrated, then with one of ``words``, then not packed."""
    calibrated = [topic for topic in topics if info_topic(topic) in infos] or topics
    named = [t for t in calibrated if any(word in t.lower() for word in words)] or calibrated
    plain = [t for t in named if not t.endswith(("/compressed", "/compressedDepth"))] or named
    return [topic for topic in plain if "rect" in topic] or plain


def _one(what: str, found: list[str], images: Mapping[str, str]) -> str:
    if len(found) == 1:
        return found[0]
    named = ", ".join(sorted(found or images)) or "none"
    trouble = "several could be it" if found else "no topic looks like it"
    raise ValueError(f"{what}_topic: {trouble}: {named}; say which")
