"""A snapshot together with what is gone from it."""

from dataclasses import replace

from sceneq_core.routing.columns import columns_of
from sceneq_core.routing.described import describe, stacked
from sceneq_core.routing.labels import Labeller
from sceneq_core.routing.row_blocks import RowBlocks
from sceneq_core.routing.scene import SceneInstance, SceneSnapshot


def with_past(snapshot: SceneSnapshot, labeller: Labeller) -> SceneSnapshot:
    """Return the snapshot as if what is gone were still there, its state ``removed``."""
    if not snapshot.past:
        return snapshot
    gone = [SceneInstance(g.geometry, g.views, g.described.label) for g in snapshot.past]
    rows = zip(snapshot.descriptors, snapshot.columns.familiarity.tolist(), strict=True)
    there = [describe(row, labeller, familiarity) for row, familiarity in rows]
    known = [
        *zip(snapshot.instances, there, strict=True),
        *zip(gone, (g.described for g in snapshot.past), strict=True),
    ]
    known.sort(key=lambda one: one[0].instance_id)
    instances = tuple(one for one, _ in known)
    matrices = stacked([described for _, described in known], labeller)
    descriptors, scores = matrices.descriptors, matrices.label_scores
    return replace(
        snapshot,
        instances=instances,
        columns=columns_of([one.geometry for one in instances], matrices),
        descriptors=RowBlocks([descriptors], descriptors.shape[1]),
        label_scores=RowBlocks([scores], scores.shape[1]),
        past=(),
    )
