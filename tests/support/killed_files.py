"""The files of a node as its sudden end leaves them."""

import shutil
from collections.abc import Callable
from pathlib import Path

from support.open_nodes import closed


def leave_as_killed(folder: Path, close: Callable[[], None]) -> None:
    """Close a node, but keep its files as they are before: closing tidies them up."""
    image = folder.with_name(folder.name + "-image")
    shutil.copytree(folder, image, ignore=shutil.ignore_patterns("*-shm"))
    closed(close)
    shutil.rmtree(folder)
    image.rename(folder)
