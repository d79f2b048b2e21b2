"""Where files are kept that can be made again."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import IO


def cache_path() -> Path:
    """Return the folder of this program in the user's cache, there or not."""
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home) / "sceneq"


def write_whole(path: Path, write: Callable[[IO[bytes]], object]) -> None:
    """Let ``write`` fill a temporary file, then give it its name: readers see all or nothing.

    Raises:
        OSError: the folder cannot be made or the file not written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".tmp", delete=False) as file:
        write(file)
    Path(file.name).replace(path)
