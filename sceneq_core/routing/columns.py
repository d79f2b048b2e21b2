"""What questions look at in all instances at once, as arrays."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from sceneq_core.arrays import Float32, Float64, Int32, Int64
from sceneq_core.mapping.delta import ROLES, Instance
from sceneq_core.routing.described import Matrices

ROLE_TEXT = f"<U{max(map(len, ROLES))}"


@dataclass(frozen=True, slots=True)
class Columns:
    """N instances.

    ``instance_id`` int32 (N,); ``role`` (N,) text; ``aabb_world`` float64 (N, 2, 3) metres;
    ``voxel_count`` int64 (N,); ``label_mean`` float32 (N,) mean cosine with the label set;
    ``colour_scores`` float32 (N, 11) cosines with ``COLOUR_TERMS``; ``familiarity`` float32 (N,):
    how much each looks like something that the encoder was taught with, 1 = the same.
    """

    instance_id: Int32
    role: NDArray[np.str_]
    aabb_world: Float64
    voxel_count: Int64
    label_mean: Float32
    colour_scores: Float32
    familiarity: Float32


def columns_of(geometry: Sequence[Instance], matrices: Matrices) -> Columns:
    """Return the columns of instances whose descriptors are in ``matrices``."""
    boxes = [one.aabb_world for one in geometry]
    return Columns(
        instance_id=np.array([one.instance_id for one in geometry], np.int32),
        role=np.array([one.role for one in geometry], ROLE_TEXT),
        aabb_world=np.array(boxes, np.float64).reshape(-1, 2, 3),
        voxel_count=np.array([one.voxel_count for one in geometry], np.int64),
        label_mean=matrices.label_scores.mean(axis=1),
        colour_scores=matrices.colour_scores,
        familiarity=matrices.familiarity,
    )


def joined(parts: Sequence[Columns]) -> Columns:
    """Return the rows of one part or more, one after the other."""
    return Columns(
        **{
            field.name: np.concatenate([getattr(part, field.name) for part in parts])
            for field in fields(Columns)
        }
    )
