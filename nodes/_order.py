"""Keyframes in the order in which they were sent, also when one has to be sent again."""

from collections.abc import Container

from sceneq_schemas.frame import Frame
from sceneq_schemas.map import MapDelta


def may_come(frame: Frame, taken: Container[int], oldest: int | None) -> bool:
    """Tell whether ``frame`` may be taken in now: nothing it is to come after is still missing.

    ``taken`` are the seqs taken in and ``oldest`` the first of them, ``None`` = nothing yet. What
    is older than that was before this reader's time and does not come any more.
    """
    before = frame.after
    if before < 0 or before == frame.seq or oldest is None:
        return True
    return before < oldest or before in taken


def says_nothing(delta: MapDelta) -> bool:
    """Tell whether a change of the map only names a frame, as after a silence."""
    columns = (delta.voxel_id, delta.removed_voxel_id, delta.moved_from_id)
    return not (any(map(len, columns)) or delta.instances or delta.events or delta.quarantined)
