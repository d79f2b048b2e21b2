"""``--source ros2:...``: a live source said in one word of the command line.

``ros2:COLOUR,DEPTH`` with topics, then any of ``key=value``: ``domain``, ``dialect``, ``distro``;
``world=FRAME`` takes poses from tf, ``odom=TOPIC`` (nav_msgs/Odometry) or ``pose=TOPIC``
(geometry_msgs/PoseStamped) from a topic; ``points=TOPIC`` takes a LiDAR in place of depth images;
``info=TOPIC`` and ``depth_info=TOPIC`` when camera_info does not lie beside the images;
``registered=yes|no``; ``sync=SECONDS``; ``patience=SECONDS`` of silence before that is said.
"""

from collections.abc import Callable
from typing import Any

from sceneq_nodes._params import did_you_mean
from sceneq_tools.errors import UserError
from sceneq_tools.graph import Override

KIND = "ros2"
SCENE = "robot"
RATE_HZ = 30.0
"""Not lossless: what the graph cannot take is dropped, and odometry sees every frame."""
NAMES: dict[str, tuple[str, Callable[[str], Any]]] = {
    "domain": ("domain", int),
    "dialect": ("dialect", str),
    "distro": ("distro", str),
    "points": ("points_topic", str),
    "info": ("camera_info_topic", str),
    "depth_info": ("depth_info_topic", str),
    "registered": ("depth_registered", str),
    "sync": ("sync_tolerance_s", float),
    "patience": ("patience_s", float),
}
"""Short name -> parameter of the source, and what reads its value."""
POSES: dict[str, Callable[[str], dict[str, str]]] = {
    "world": lambda frame: {"kind": "tf", "world_frame": frame},
    "odom": lambda topic: {"kind": "topic", "topic": topic},
    "pose": lambda topic: {
        "kind": "topic",
        "topic": topic,
        "type": "geometry_msgs/msg/PoseStamped",
    },
}


def is_live(source: object) -> bool:
    """Tell a live source from the path of a recording."""
    return str(source).startswith(f"{KIND}:")


def need_live_options(step: int | None, loop: bool) -> None:
    """Refuse options of a recording."""
    given = {"--step": step is not None, "--loop": loop}
    if clash := [option for option, is_given in given.items() if is_given]:
        raise UserError(f"{', '.join(clash)}: a robot is no recording", 2)


def live_overrides(
    source: object, scene: str | None, rate: float | None, no_poses: bool = False
) -> list[Override]:
    """Return what a live source puts over the graph file; ``UserError`` when it is not one."""
    spec = ros2_source(str(source).partition(":")[2])
    if no_poses:
        spec.pop("pose", None)
    return [
        Override("", ("scene",), scene or SCENE, "--source"),
        Override("ingest", ("source",), spec, "--source"),
        Override("ingest", ("rate_hz",), RATE_HZ if rate is None else rate, "--rate"),
    ]


def ros2_source(text: str) -> dict[str, Any]:
    """Return the specification of the source that ``text`` says."""
    words = text.split(",")
    topics = [word for word in words if "=" not in word]
    if not 1 <= len(topics) <= 2 or not all(topics):
        raise UserError(f"--source {KIND}:{text}: expected {KIND}:COLOUR,DEPTH[,key=value...]", 2)
    spec: dict[str, Any] = {"kind": KIND}
    spec |= dict(zip(("colour_topic", "depth_topic"), topics, strict=False))
    for name, _, value in (word.partition("=") for word in words if "=" in word):
        if name in POSES:
            spec["pose"] = POSES[name](value)
        elif name in NAMES:
            spec[NAMES[name][0]] = _value(name, value)
        else:
            hint = did_you_mean(name, set(NAMES) | set(POSES))
            raise UserError(f"--source {KIND}: unknown key '{name}' ({hint})", 2)
    return spec


def _value(name: str, value: str) -> Any:
    try:
        return NAMES[name][1](value)
    except ValueError as error:
        raise UserError(f"--source {KIND}: {name}={value}: {error}", 2) from error
