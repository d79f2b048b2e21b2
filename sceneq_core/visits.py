"""Frames of several recordings in one scene, each under a number of its own.

A *visit* is one run of one robot's source: its frames count from 0 again, its poses may be in a
frame of reference of its own. In the scene, frame ``seq`` of visit ``v`` is ``v << 32 | seq``:
those of the first visit keep their numbers, and every number tells where it comes from.
"""

VISIT_BITS = 32
MOST_VISITS = 1 << 20
"""So that numbers stay below the 2**53 that a JSON reader keeps exactly."""


def seq_in_scene(visit: int, seq: int) -> int:
    """Return the number in the scene of a visit's frame ``seq``.

    Raises:
        ValueError: a number that does not fit.
    """
    if not (0 <= visit < MOST_VISITS and 0 <= seq < 1 << VISIT_BITS):
        raise ValueError(f"frame {seq} of visit {visit}: out of range")
    return visit << VISIT_BITS | seq


def visit_of(seq_in_scene: int) -> int:
    """Return the number of the visit that a frame is of."""
    return max(seq_in_scene, 0) >> VISIT_BITS


def seq_of(seq_in_scene: int) -> int:
    """Return the number that a frame has in its own recording."""
    return seq_in_scene & ((1 << VISIT_BITS) - 1)


def is_same_visit(one: int, other: int) -> bool:
    """Tell whether two frames of a scene are of one visit."""
    return visit_of(one) == visit_of(other)
