"""Masks of things in 3D that somebody else proposes: Mask3D, OneFormer3D, any."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from sceneq_core.arrays import Float32, Int32

NO_MASK = -1


@dataclass(frozen=True, slots=True)
class Proposals:
    """P masks over N points of a cloud in the frame of the map.

    ``points_world`` float32 (N, 3), metres, any density, points of no mask included; ``mask_id``
    and ``point_id`` int32 (M,): point ``point_id[i]`` belongs to mask ``mask_id[i]``, of 0..P-1.
    Masks may overlap. ``score`` float32 (P,), higher is better; ``label`` P names, or none at all.
    """

    points_world: Float32
    mask_id: Int32
    point_id: Int32
    score: Float32
    label: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.points_world.ndim != 2 or self.points_world.shape[1] != 3:
            raise ValueError(f"points_world: expected (N, 3), got {self.points_world.shape}")
        if not np.isfinite(self.points_world).all():
            raise ValueError("points_world: not finite")
        if self.mask_id.ndim != 1 or self.mask_id.shape != self.point_id.shape:
            raise ValueError("mask_id: expected as many as point_id, in one dimension")
        _need_ids("mask_id", self.mask_id, len(self.score))
        _need_ids("point_id", self.point_id, len(self.points_world))
        if self.score.ndim != 1 or not np.isfinite(self.score).all():
            raise ValueError("score: expected one finite number for every mask")
        if self.label and len(self.label) != len(self.score):
            raise ValueError(f"label: expected {len(self.score)} or none, got {len(self.label)}")

    def of_points(self) -> Int32:
        """Return int32 (N,) the mask of each point, the one with the best score; -1 = none."""
        of_point = np.full(len(self.points_world), NO_MASK, np.int32)
        order = np.lexsort((-self.mask_id, self.score[self.mask_id]))
        of_point[self.point_id[order]] = self.mask_id[order]  # the best is written last
        return of_point


class ProposalSource(Protocol):
    """Where proposals come from before the first frame."""

    Params: ClassVar[type]

    def load(self) -> Proposals | None:
        """Return the proposals, ``None`` when there are none.

        Raises:
            ValueError: what is there is no proposals; the message names the file and the field.
        """


@dataclass(frozen=True, slots=True)
class NoProposalsParams:
    """Nothing to choose."""


class NoProposals:
    """The map proposes for itself, from the 2D segments."""

    Params: ClassVar[type] = NoProposalsParams

    def __init__(self, params: NoProposalsParams) -> None:
        """Do nothing."""

    def load(self) -> None:
        """Return none."""
        return


def _need_ids(name: str, ids: Int32, count: int) -> None:
    if len(ids) and not 0 <= ids.min() <= ids.max() < count:
        raise ValueError(f"{name}: expected 0 to {count - 1}, got {ids.min()} to {ids.max()}")
