"""Which Zenoh keys of ROS 2 a source listens to, and which the results go out on.

Access rules are made of them: what is not here is denied where 'secure' is on (docs/security.md).
"""

from dataclasses import dataclass

from sceneq_nodes.ros.keys import selectors
from sceneq_nodes.ros.output import RosOutputParams, published_topics
from sceneq_nodes.ros.params import Ros2Params
from sceneq_nodes.ros.source import topic_roles


@dataclass(frozen=True, slots=True)
class RosKeys:
    """Key expressions: ``read`` from a robot, of its caches ``latched``, ``written`` to it.

    ``tokens``: liveliness by which ROS finds the publishers of what is written.
    """

    read: tuple[str, ...] = ()
    latched: tuple[str, ...] = ()
    written: tuple[str, ...] = ()
    tokens: tuple[str, ...] = ()

    def __or__(self, other: "RosKeys") -> "RosKeys":
        """Return the keys of both, each once, in a fixed order."""
        return RosKeys(
            _all(self.read, other.read),
            _all(self.latched, other.latched),
            _all(self.written, other.written),
            _all(self.tokens, other.tokens),
        )


def source_keys(params: Ros2Params) -> RosKeys:
    """Return the keys of everything that a source listens to."""
    read: list[str] = []
    latched: list[str] = []
    for topic in topic_roles(params):
        keys = selectors(topic.topic, params.domain, params.dialect)
        read += keys
        latched += keys if topic.latched else []
    return RosKeys(read=_all(read), latched=_all(latched))


def output_keys(params: RosOutputParams) -> RosKeys:
    """Return the keys of the results, and of the tokens that come with them."""
    written: list[str] = []
    for topic in published_topics(params.prefix):
        written += selectors(topic, params.domain, params.dialect)
    is_bridge = params.dialect == "bridge"
    tokens = () if is_bridge else (f"@ros2_lv/{params.domain}/**",)
    return RosKeys(written=_all(written), tokens=tokens)


def _all(*some: "tuple[str, ...] | list[str]") -> tuple[str, ...]:
    return tuple(sorted({key for keys in some for key in keys}))
