"""A snapshot together with what is gone from it."""

from dataclasses import replace

import numpy as np

from sceneq_core.routing.columns import columns_of
from sceneq_core.routing.described import describe
from sceneq_core.routing.labels import Labeller
from sceneq_core.routing.row_blocks import RowBlocks
from sceneq_core.routing.scene import SceneInstance, SceneSnapshot


def with_past(snapshot: SceneSnapshot, labeller: Labeller) -> SceneSnapshot:
    """Return the snapshot as if what is gone were still there, its state ``removed``."""
    if not snapshot.past:
        return snapshot
    gone = [SceneInstance(g.geometry, g.views, g.described.label) for g in snapshot.past]
    known = [
        *zip(snapshot.instances, snapshot.descriptors, strict=True),
        *zip(gone, (g.described.descriptor for g in snapshot.past), strict=True),
    ]
    known.sort(key=lambda one: one[0].instance_id)
    instances = tuple(one for one, _ in known)
    descriptors = np.stack([row for _, row in known])
    described = [describe(row, labeller) for row in descriptors]
    scores = np.stack([one.label_scores for one in described])
    colours = np.stack([one.colour_scores for one in described])
    return replace(
        snapshot,
        instances=instances,
        columns=columns_of([one.geometry for one in instances], scores, colours),
        descriptors=RowBlocks([descriptors], descriptors.shape[1]),
        label_scores=RowBlocks([scores], scores.shape[1]),
        past=(),
    )
