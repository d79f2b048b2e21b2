"""Crops of true things with their names: what the conse encoder is taught with."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, UInt8
from sceneq_core.encoding.pyramid import pyramid
from sceneq_core.encoding.usual_sizes import shape_of
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_core.views.view import View
from sceneq_tools.evaluation.oracle import true_views
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.true_things import THINGS_FILE, read_things
from sceneq_tools.progress import Advance
from sceneq_tools.room.portrait.album import is_album, pages


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """One view of a thing: ``names`` (the first is taught), ``features`` (L, F), ``shape`` (4,)."""

    names: tuple[str, ...]
    features: Float32
    shape: Float64


def examples(folder: Path, setup: Setup, advance: Advance) -> Iterator[Example]:
    """Yield what is in a folder, of ``sceneq synth`` or of ``sceneq portraits``, as it looks to the
    encoder; ``advance`` counts things.

    Raises:
        UserError: a file that is missing or malformed.
    """
    return (_portrayed if is_album(folder) else _recorded)(folder, setup, advance)


def as_arrays(found: Sequence[Example]) -> tuple[list[str], Float32]:
    """Return one name per crop and the features (N, F)."""
    names = [one.names[0] for one in found for _ in range(len(one.features))]
    return names, np.concatenate([one.features for one in found])


def digest(found: Sequence[Example]) -> str:
    """Return a fingerprint of the examples."""
    hashed = hashlib.sha256()
    for one in found:
        hashed.update(json.dumps(one.names).encode())
        hashed.update(one.features.astype(np.float16).tobytes())
    return hashed.hexdigest()[:16]


def _recorded(folder: Path, setup: Setup, advance: Advance) -> Iterator[Example]:
    """Yield the views and crops of a recording that a robot would choose."""
    names = {thing.id: thing.names for thing in read_things(folder / THINGS_FILE)}
    shapes = _shapes(folder)
    selector = true_views(folder, setup)
    for view_set in selector.view_sets():
        key = view_set.instance_id
        for view in view_set.views:
            jpeg = selector.image(view.seq)
            if jpeg is not None:
                features = _features(setup, rgb_from_jpeg(jpeg), view)
                yield Example(names[key], features, shapes[key])
        advance()


def _portrayed(folder: Path, setup: Setup, advance: Advance) -> Iterator[Example]:
    for page in pages(folder):
        view = _whole_view(page.mask)
        yield Example((page.name,), _features(setup, page.rgb, view), page.shape)
        advance()


def _features(setup: Setup, rgb: UInt8, view: View) -> Float32:
    crops = pyramid(rgb, view, setup.describe.levels, setup.describe.expand)
    return setup.encoder.encode_crops(crops)[1]


def _whole_view(mask: Bool) -> View:
    left, top, width, height = cv2.boundingRect(mask.astype(np.uint8))
    box = np.array([left, top, left + width, top + height], np.float32)
    part = mask[top : top + height : 2, left : left + width : 2]
    return View(0, 0, int(mask.sum()), box, part)


def _shapes(folder: Path) -> dict[int, Float64]:
    """Return the shape (4,) of every thing of a recording with z up and the floor at 0."""
    shapes = {}
    for record in json.loads((folder / THINGS_FILE).read_text())["instances"]:
        box = next((stay["box"] for stay in reversed(record["history"]) if stay["box"]), None)
        if box is not None:
            low, high = np.array(box, np.float64)
            sides = record.get("oriented_box", {}).get("size", (high - low).tolist())[:2]
            shapes[int(record["id"])] = shape_of(sides, high[2] - low[2], low[2])
    return shapes
