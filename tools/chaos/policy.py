"""Which class every topic has, who reads it and how much may wait: a table of docs/reliability.md.

``python -m sceneq_tools.chaos.policy`` prints it.
"""

from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path

from sceneq_nodes._bus import Node
from sceneq_nodes.encoding import Encoding
from sceneq_nodes.ingest import Ingest
from sceneq_nodes.mapping import Mapping
from sceneq_nodes.segmentation import Segmentation
from sceneq_nodes.views import Views
from sceneq_schemas.topics import TOPICS, Delivery, Topic
from sceneq_tools.chaos.small_scene import HASH, SCENE, LoneBus, known_scene

COLUMNS = ("topic", "class", "at most", "read by (messages that wait)")
WATCHED = "`sceneq status`, `metrics`, `up`"


def rows() -> Iterator[tuple[str, str, str, str]]:
    """Yield the cells of every topic."""
    readers = depths()
    for topic in TOPICS:
        read = ", ".join(f"{node} ({depth})" for node, depth in readers.get(topic.name, ()))
        if topic.delivery is Delivery.BACKGROUND:
            read = WATCHED
        yield f"`{topic.pattern}`", topic.delivery.name.lower(), _size(topic), read


def as_markdown() -> str:
    """Return the table."""
    lines = [COLUMNS, tuple("---" for _ in COLUMNS), *rows()]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def depths() -> dict[str, list[tuple[str, int]]]:
    """Return who reads a topic, and how many messages wait for them at most, by topic."""
    found: dict[str, list[tuple[str, int]]] = {}
    for name, bus in _opened():
        for topic, depth in bus.subscriptions.items():
            found.setdefault(topic, []).append((name, depth))
    return found


def _opened() -> Iterator[tuple[str, LoneBus]]:
    sample = {"kind": "folder", "path": str(Path(str(files("sceneq_tools"))) / "sample")}
    nodes: dict[str, Node] = {
        "ingest": Ingest(Ingest.Params(source=sample, rate_hz=0), SCENE),
        "segmentation": Segmentation(Segmentation.Params(), SCENE),
        "mapping": Mapping(Mapping.Params(), SCENE),
        "views": Views(Views.Params(), SCENE),
        "encoding": Encoding(Encoding.Params(encoder=HASH, nice=0), SCENE),
    }
    for name, node in nodes.items():
        bus = LoneBus()
        node.open(bus)
        yield name, bus
    yield "routing", known_scene()[1]


def _size(topic: Topic) -> str:
    if not topic.max_bytes:
        return ""
    mib = topic.max_bytes / (1024 * 1024)
    return f"{mib:g} MiB" if mib >= 1 else f"{topic.max_bytes // 1024} KiB"


if __name__ == "__main__":
    print(as_markdown())
