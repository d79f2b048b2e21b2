"""Which instances does somebody point at in a keyframe?"""

from sceneq_core.routing.scene import Box, SceneSnapshot

MIN_OVERLAP = 0.3
"""A box drawn by hand that shares less with a view's box is about something else."""


def at_point(snapshot: SceneSnapshot, seq: int, x: float, y: float) -> list[int]:
    """Return the ids of instances with a view in keyframe ``seq`` whose box (pixels) holds a point.

    The smallest box first: what stands before something larger is inside its box.
    """
    found = [
        (_area(box), instance_id)
        for instance_id, box in _boxes(snapshot, seq)
        if box[0] <= x <= box[2] and box[1] <= y <= box[3]
    ]
    return [instance_id for _, instance_id in sorted(found)]


def in_box(snapshot: SceneSnapshot, seq: int, box: Box) -> list[int]:
    """Return the ids of instances whose box in keyframe ``seq`` is like ``box``, best first."""
    found = [(_overlap(box, other), -key) for key, other in _boxes(snapshot, seq)]
    return [-key for overlap, key in sorted(found, reverse=True) if overlap >= MIN_OVERLAP]


def keyframes(snapshot: SceneSnapshot) -> list[int]:
    """Return the numbers of all keyframes that show an instance."""
    return sorted({view.seq for one in snapshot.instances for view in one.views})


def _boxes(snapshot: SceneSnapshot, seq: int) -> list[tuple[int, Box]]:
    return [
        (one.instance_id, view.box_xyxy)
        for one in snapshot.instances
        for view in one.views
        if view.seq == seq
    ]


def _area(box: Box) -> float:
    return max(box[2] - box[0], 0.0) * max(box[3] - box[1], 0.0)


def _overlap(one: Box, other: Box) -> float:
    low = (max(one[0], other[0]), max(one[1], other[1]))
    high = (min(one[2], other[2]), min(one[3], other[3]))
    both = _area((*low, *high))
    union = _area(one) + _area(other) - both
    return both / union if union > 0 else 0.0
