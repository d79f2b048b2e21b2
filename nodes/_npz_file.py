"""Arrays in an ``.npz`` file, bounded; everything wrong with one is a ``ValueError``."""

import io
import zipfile
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Array

MIB = 1024 * 1024


def read_arrays(path: Path, max_mb: int) -> dict[str, Array]:
    """Return the arrays of a file by name, of ``max_mb`` MiB together at most.

    Raises:
        OSError: the file cannot be read.
        ValueError: no such archive, one that unpacks to more, or something else than arrays in it.
    """
    data = path.read_bytes()
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size = sum(member.file_size for member in archive.infolist())
        if size > max_mb * MIB:
            raise ValueError(f"unpacks to {size} bytes, the limit is {max_mb} MiB")
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
    except Exception as error:  # a damaged file fails in many ways inside zipfile and numpy
        raise ValueError(f"no .npz file: {error!r:.120}") from error
    if foreign := [name for name, array in arrays.items() if not isinstance(array, np.ndarray)]:
        raise ValueError(f"{foreign[0]!r:.40}: no array")
    return arrays
