"""Portraits on disk: one ``.npz`` a room, read back as crops."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float64, UInt8
from sceneq_core.encoding.usual_sizes import shape_of
from sceneq_tools.errors import UserError
from sceneq_tools.room.portrait.photographer import Portrait

PATTERN = "portraits-*.npz"


@dataclass(frozen=True, slots=True, eq=False)
class Page:
    """A portrait of a ``model``: picture ``rgb`` (h, w, 3), ``mask`` (h, w), ``shape`` (4,)."""

    name: str
    model: str
    rgb: UInt8
    mask: Bool
    shape: Float64


def keep(folder: Path, number: int, taken: Sequence[Portrait]) -> None:
    """Write the portraits of a room."""
    entries: dict[str, np.ndarray] = {
        "name": np.array([one.posed.sitter.name for one in taken]),
        "model": np.array([one.posed.sitter.model_id for one in taken]),
        "shape": np.array([_shape(one) for one in taken]),
    }
    for row, one in enumerate(taken):
        entries[f"jpeg_{row}"] = np.frombuffer(one.jpeg, np.uint8)
        entries[f"mask_{row}"] = np.packbits(one.mask)
    with (folder / f"portraits-{number:04d}.npz").open("wb") as file:
        np.savez(file, allow_pickle=False, **entries)


def is_album(folder: Path) -> bool:
    """Return whether there are portraits in a folder."""
    return any(folder.glob(PATTERN))


def pages(folder: Path) -> Iterator[Page]:
    """Yield all portraits of a folder.

    Raises:
        UserError: a file that is damaged; it is named.
    """
    for path in sorted(folder.glob(PATTERN)):
        try:
            with np.load(path, allow_pickle=False) as arrays:
                names, models = arrays["name"].tolist(), arrays["model"].tolist()
                shapes = arrays["shape"]
                for row, (name, model) in enumerate(zip(names, models, strict=True)):
                    bgr = cv2.imdecode(arrays[f"jpeg_{row}"], cv2.IMREAD_COLOR)
                    if bgr is None:
                        raise ValueError(f"jpeg_{row} is no picture")
                    rgb = np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)
                    count = rgb.shape[0] * rgb.shape[1]
                    bits = np.unpackbits(arrays[f"mask_{row}"], count=count)
                    mask = bits.reshape(rgb.shape[:2]) > 0
                    yield Page(str(name), str(model), rgb, mask, shapes[row])
        except (OSError, ValueError, KeyError, cv2.error) as error:
            raise UserError(f"{path}: no portraits: {error!r:.120}", 2) from error


def _shape(portrait: Portrait) -> Float64:
    posed = portrait.posed
    return shape_of(posed.size[:2].tolist(), float(posed.size[2]), posed.underside_m)
