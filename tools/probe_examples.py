"""Crops of true things with their names: what the conse encoder is taught with."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from sceneq_core.arrays import Bool, Float32, Float64, UInt8
from sceneq_core.encoding.joint import unit
from sceneq_core.encoding.pyramid import pyramid
from sceneq_core.encoding.usual_sizes import shape_of
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_core.views.view import View
from sceneq_tools.evaluation.oracle import true_views
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.true_things import THINGS_FILE, read_things
from sceneq_tools.progress import Advance
from sceneq_tools.room.portrait.album import is_album, pages

QUARTERS = 4
"""Parts that all models of furniture fall into, to teach with three of them."""


@dataclass(frozen=True, slots=True, eq=False)
class Example:
    """One view of a thing: ``names`` (the first is taught), ``features`` (L, F), ``shape`` (4,).

    ``model`` of furniture, '' = none. ``thing``: which single thing it is, of those in a folder
    of a recording, or of the models in an album.
    """

    names: tuple[str, ...]
    features: Float32
    shape: Float64
    model: str
    thing: str


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


def as_things(found: Sequence[Example]) -> Float32:
    """Return one feature per thing (T, F), of length 1, by their first appearance.

    The mean over its views of their means over levels: as instances are described.
    """
    views: dict[str, list[Float32]] = {}
    for one in found:
        views.setdefault(one.thing, []).append(one.features.mean(axis=0))
    return np.stack([unit(np.mean(seen, axis=0)) for seen in views.values()])


def quarter(model: str) -> int:
    """Return which quarter, 1 to 4, a model falls into, whatever the others are."""
    fingerprint = hashlib.md5(model.encode(), usedforsecurity=False).hexdigest()
    return 1 + int(fingerprint, 16) % QUARTERS


def without_quarter(
    found: Sequence[Example], number: int | None
) -> tuple[list[Example], list[str]]:
    """Return the examples without the models of a quarter, and these models, sorted.

    What has no model stays; with ``None`` everything does.
    """
    models = {one.model for one in found if one.model}
    withheld = {model for model in models if quarter(model) == number}
    return [one for one in found if one.model not in withheld], sorted(withheld)


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
    shapes, models = _shapes(folder), _models(folder)
    selector = true_views(folder, setup)
    for view_set in selector.view_sets():
        key = view_set.instance_id
        for view in view_set.views:
            jpeg = selector.image(view.seq)
            if jpeg is not None:
                features = _features(setup, rgb_from_jpeg(jpeg), view)
                thing = f"{folder}/{key}"
                yield Example(names[key], features, shapes[key], models[key], thing)
        advance()


def _portrayed(folder: Path, setup: Setup, advance: Advance) -> Iterator[Example]:
    for page in pages(folder):
        view = _whole_view(page.mask)
        features = _features(setup, page.rgb, view)
        yield Example((page.name,), features, page.shape, page.model, thing=page.model)
        advance()


def _features(setup: Setup, rgb: UInt8, view: View) -> Float32:
    crops = pyramid(rgb, view, setup.describe.levels, setup.describe.expand)
    return setup.encoder.encode_crops(crops)[1]


def _whole_view(mask: Bool) -> View:
    left, top, width, height = cv2.boundingRect(mask.astype(np.uint8))
    box = np.array([left, top, left + width, top + height], np.float32)
    part = mask[top : top + height : 2, left : left + width : 2]
    return View(0, 0, int(mask.sum()), box, part)


def _models(folder: Path) -> dict[int, str]:
    """Return the model of furniture of every thing of a recording, '' = none is told."""
    records = json.loads((folder / THINGS_FILE).read_text())["instances"]
    return {int(record["id"]): str(record.get("model") or "") for record in records}


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
