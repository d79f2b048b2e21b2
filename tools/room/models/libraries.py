"""Which library of models there is to build rooms from."""

import logging
import os
from pathlib import Path

from sceneq_tools.room.library import Library
from sceneq_tools.room.models.shapes import ParametricLibrary
from sceneq_tools.room.models.sweet_home import SweetHomeLibrary

FOLDER_VARIABLE = "SCENEQ_FURNITURE_DIR"
DEFAULT_FOLDER = Path("/usr/share/sweethome3d/furniture")
PACKAGE_HINT = "apt-get install sweethome3d-furniture"

_log = logging.getLogger(__name__)


def furniture_folder() -> Path:
    """Return where the furniture package is looked for."""
    return Path(os.environ.get(FOLDER_VARIABLE) or DEFAULT_FOLDER)


def open_library(folder: Path | None = None) -> Library:
    """Open the furniture package, or our own simple shapes where it is not installed.

    Args:
        folder: of ``.sh3f`` archives; ``None``: ``SCENEQ_FURNITURE_DIR``, else the place where
            Debian's package puts them.

    Returns:
        the library; its ``name`` says which one it is.

    Raises:
        ValueError: there are archives, but they cannot be read.
    """
    folder = furniture_folder() if folder is None else folder
    if any(folder.glob("*.sh3f")):
        return SweetHomeLibrary(folder)
    _log.info("no furniture in %s, using simple shapes; for real ones: %s", folder, PACKAGE_HINT)
    return ParametricLibrary()
