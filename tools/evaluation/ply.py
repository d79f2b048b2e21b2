"""Vertices of a PLY mesh or cloud."""

from pathlib import Path

from sceneq_core.arrays import Float32
from sceneq_nodes import _ply_file
from sceneq_tools.errors import UserError


def read_vertices(path: Path) -> Float32:
    """Return the vertices float32 (N, 3) of a PLY file, in its own unit.

    Raises:
        UserError: the file is missing, is no PLY, or does not hold what its header says.
    """
    try:
        return _ply_file.read_vertices(path)
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}", 2) from error
    except ValueError as error:
        raise UserError(f"{path}: {error}", 2) from error
