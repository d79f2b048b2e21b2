"""When the room changes: while nobody looks, between two looks at the same places."""

from collections.abc import Sequence

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.library import Library
from sceneq_tools.room.room import Room
from sceneq_tools.room.truth.boxes import world_box
from sceneq_tools.room.truth.truth import Period

ATTEMPTS = 6
MIDDLE = (0.3, 0.7)
"""The part of the recording in which the room may change: both states are seen for long."""
SEEN_WITHIN_M = 4.0
"""A small thing further away than this is only a few pixels."""


def there_and_back(path: Sequence[Float64]) -> list[Float64]:
    """Return a path walked to its end and back: every place is seen twice."""
    return [*path, *reversed(path)]


def changing_room(
    room: Room,
    library: Library,
    poses: Sequence[Float64],
    camera: Camera,
    rng: np.random.Generator,
    count: int,
) -> tuple[Period, Period]:
    """Return the room before and after ``count`` chance edits, and the frame they happen at.

    Of several chances it takes the one whose places are seen before and after, and out of view
    at the moment itself.

    Raises:
        ValueError: the room has nothing that can be changed.
    """
    from sceneq_tools.room.layout.edits import random_changes

    best: tuple[float, int, Room, list[str]] | None = None
    for _ in range(ATTEMPTS):
        changed, words = random_changes(room, library, rng, count)
        score, frame = _best_moment(room, changed, poses, camera)
        if best is None or score > best[0]:
            best = score, frame, changed, words
    assert best is not None
    return Period(0, room), Period(best[1], best[2], tuple(best[3]))


def in_view(points_world: Float64, poses: Sequence[Float64], camera: Camera) -> Bool:
    """Return which of the points (N, 3) lie in which frame's view, (frames, N), walls ignored."""
    T_camera_world = np.linalg.inv(np.stack(poses))
    local = (
        points_world @ T_camera_world[:, :3, :3].transpose(0, 2, 1) + T_camera_world[:, None, :3, 3]
    )
    z = np.where(local[..., 2] > 0.2, local[..., 2], np.inf)
    pixels = local[..., :2] / z[..., None] * camera.K[[0, 1], [0, 1]] + camera.K[:2, 2]
    inside = ((pixels >= 0) & (pixels < camera.size)).all(-1)
    seen: Bool = inside & (z <= SEEN_WITHIN_M)
    return seen


def _best_moment(
    before: Room, after: Room, poses: Sequence[Float64], camera: Camera
) -> tuple[float, int]:
    """Return how good the best frame for the change is, and the frame."""
    places = _changed_places(before, after)
    first, last = (round(share * len(poses)) for share in MIDDLE)
    moments = np.arange(max(1, first), max(2, last))
    seen = in_view(places, poses, camera)
    scores = [_score(seen, int(frame)) for frame in moments]
    best = int(np.argmax(scores))
    return scores[best], int(moments[best])


def _score(seen: Bool, frame: int) -> float:
    """Count the places seen before and after, less those in view while they change."""
    earlier: Int64 = np.minimum(seen[:frame].sum(0), 3)
    later: Int64 = np.minimum(seen[frame:].sum(0), 3)
    watched = seen[max(0, frame - 1) : frame + 1].any(0)
    return float((earlier + later - 6 * watched).sum())


def _changed_places(before: Room, after: Room) -> Float64:
    """Return the middles (N, 3) of the boxes that are only in one of the two rooms."""
    old = {thing.id: world_box(thing) for thing in before.things}
    new = {thing.id: world_box(thing) for thing in after.things}
    places = [
        box.mean(0)
        for mine, theirs in ((old, new), (new, old))
        for thing_id, box in mine.items()
        if thing_id not in theirs or np.abs(theirs[thing_id] - box).max() > 1e-4
    ]
    if not places:
        raise ValueError(f"{before.kind} {before.seed}: nothing in the room can be changed")
    return np.stack(places)
