"""What a 3D network, or anybody, writes to propose the things of a scene."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from sceneq_schemas.arrays import Array, ArraySpec


@dataclass(frozen=True, slots=True)
class ProposalSet:
    """P masks over N points, metres, in the frame of the map; replaces earlier proposals.

    Point ``point_id[i]`` belongs to mask ``mask_id[i]``, of 0..P-1; masks may overlap, then the one
    with the higher ``score`` counts. Points of no mask belong here too. ``label`` is empty
    or names every mask.
    """

    VERSION: ClassVar[int] = 1
    SCHEMA: ClassVar[str] = "sceneq.proposal.v1"
    stamp_ns: int
    source: str
    points_world: Annotated[Array, ArraySpec("<f4", (None, 3))]
    mask_id: Annotated[Array, ArraySpec("<i4", (None,))]
    point_id: Annotated[Array, ArraySpec("<i4", (None,))]
    score: Annotated[Array, ArraySpec("<f4", (None,))]
    label: tuple[str, ...] = ()
