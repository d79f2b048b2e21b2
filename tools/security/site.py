"""What a site knows of itself, beside its authority: its scenes and the ROS 2 keys let through."""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

from sceneq_nodes.ros.passage import RosKeys

FILE = "site.json"


@dataclass(frozen=True, slots=True)
class Site:
    """Access rules are made of this; ``ros`` is empty, so nothing of ROS passes, by default."""

    scenes: tuple[str, ...] = ()
    ros: RosKeys = field(default_factory=RosKeys)


def read_site(authority: Path) -> Site:
    """Return what was written, nothing when nothing was."""
    path = authority / FILE
    if not path.is_file():
        return Site()
    told = json.loads(path.read_text())
    ros = {name: tuple(keys) for name, keys in told.get("ros", {}).items()}
    return Site(tuple(told["scenes"]), RosKeys(**ros))


def write_site(authority: Path, site: Site) -> None:
    """Keep it for the next time."""
    (authority / FILE).write_text(json.dumps(asdict(site)) + "\n")
