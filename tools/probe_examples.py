"""Crops of true things with their names: what a probe is taught with."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Float32
from sceneq_core.encoding.pyramid import pyramid
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_tools.evaluation.oracle import true_views
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.true_things import THINGS_FILE, read_things
from sceneq_tools.progress import Advance

Example = tuple[str, Float32]
"""A name, and the features (L, F) of one view of a thing that is called so."""


def examples(folder: Path, setup: Setup, advance: Advance) -> Iterator[Example]:
    """Yield what the views of the true things in a rendered recording look like to the encoder.

    Views and crops are those a robot would choose. ``advance`` counts things.

    Raises:
        UserError: a file of the recording that is missing or malformed.
    """
    label = {thing.id: thing.names[0] for thing in read_things(folder / THINGS_FILE)}
    selector = true_views(folder, setup)
    levels, expand = setup.describe.levels, setup.describe.expand
    for view_set in selector.view_sets():
        for view in view_set.views:
            jpeg = selector.image(view.seq)
            if jpeg is not None:
                crops = pyramid(rgb_from_jpeg(jpeg), view, levels, expand)
                yield label[view_set.instance_id], setup.encoder.encode_crops(crops)[1]
        advance()


def as_arrays(found: Sequence[Example]) -> tuple[list[str], Float32]:
    """Return one name per crop and the features (N, F)."""
    names = [name for name, features in found for _ in range(len(features))]
    return names, np.concatenate([features for _, features in found])
