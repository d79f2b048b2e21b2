"""When the room changes: while nobody looks, between two looks at the same places."""

from collections.abc import Sequence

import numpy as np

from sceneq_core.arrays import Bool, Float64, Int64
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.library import Library
from sceneq_tools.room.room import Room
from sceneq_tools.room.truth.boxes import world_box
from sceneq_tools.room.truth.truth import Period

ATTEMPTS = 4
"""So often a change is drawn again when one of its places is not seen well."""
GLANCES = 24
"""So many looks tell what a part of the recording shows."""
LEAST_PIXELS = 128
"""A thing with fewer pixels was not seen: two rays of a glance."""
SEEN_OFTEN = 3
"""So many looks are enough."""
SAME_M = 1e-4
"""A box that differs by no more has not moved."""
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

    What changes is seen well before and after, and out of view at the moment itself, as far as
    several chances allow.

    Raises:
        ValueError: the room has nothing that can be changed.
    """
    first, last = _middle(poses)
    changed, told = room, []
    for _ in range(count):
        done = {i for ids in _changed_ids(room, changed) for i in ids}
        changed, words = _one_change(
            changed, library, poses[:first], poses[last:], camera, rng, done
        )
        told += words
    return Period(0, room), Period(_best_moment(room, changed, poses, camera), changed, tuple(told))


def _one_change(
    room: Room,
    library: Library,
    before: Sequence[Float64],
    after: Sequence[Float64],
    camera: Camera,
    rng: np.random.Generator,
    done: set[int],
) -> tuple[Room, list[str]]:
    """Return the room after one more change whose places are seen ``before`` and ``after``."""
    from sceneq_tools.room.layout.edits import random_changes

    shown = _shown(room, before, camera)
    seen = {i for i, often in shown.items() if often and i not in done} or None
    best: tuple[int, Room, list[str]] | None = None
    for _ in range(ATTEMPTS):
        changed, words = random_changes(room, library, rng, 1, seen)
        old, new = _changed_ids(room, changed)
        later = _shown(changed, after, camera)
        score = min(
            [min(shown[i], SEEN_OFTEN) for i in old] + [min(later[i], SEEN_OFTEN) for i in new],
            default=-1,
        )
        if best is None or score > best[0]:
            best = score, changed, words
        if score == SEEN_OFTEN:
            break
    assert best is not None
    return best[1:]


def _shown(room: Room, poses: Sequence[Float64], camera: Camera) -> dict[int, int]:
    """Return in how many of some looks from ``poses`` each thing is seen well, by id."""
    from sceneq_tools.room.camera.glance import Glance

    glance = Glance(room, camera)
    looks = poses[:: -(-len(poses) // GLANCES) or 1]
    often: Int64 = np.zeros(len(glance.ids), np.int64)
    for T_world_camera in looks:
        often += glance.at(T_world_camera).pixels >= LEAST_PIXELS
    return dict(zip(glance.ids.tolist(), often.tolist(), strict=True))


def _changed_ids(before: Room, after: Room) -> tuple[list[int], list[int]]:
    """Return the ids of what is no longer as it was, and of what was not so before."""
    old = {thing.id: world_box(thing) for thing in before.things}
    new = {thing.id: world_box(thing) for thing in after.things}
    return _unlike(old, new), _unlike(new, old)


def _unlike(mine: dict[int, Float64], theirs: dict[int, Float64]) -> list[int]:
    return [
        thing_id
        for thing_id, box in mine.items()
        if thing_id not in theirs or np.abs(theirs[thing_id] - box).max() > SAME_M
    ]


def _middle(poses: Sequence[Float64]) -> tuple[int, int]:
    """Return the first frame at which the room may change, and the last."""
    first, last = (round(share * len(poses)) for share in MIDDLE)
    return max(1, first), max(2, last)


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


def _best_moment(before: Room, after: Room, poses: Sequence[Float64], camera: Camera) -> int:
    """Return the best frame for the change."""
    moments = np.arange(*_middle(poses))
    seen = in_view(_changed_places(before, after), poses, camera)
    return int(moments[int(np.argmax([_score(seen, int(frame)) for frame in moments]))])


def _score(seen: Bool, frame: int) -> float:
    """Count the places seen before and after, less those in view while they change."""
    earlier: Int64 = np.minimum(seen[:frame].sum(0), 3)
    later: Int64 = np.minimum(seen[frame:].sum(0), 3)
    watched = seen[max(0, frame - 1) : frame + 1].any(0)
    return float((earlier + later - 6 * watched).sum())


def _changed_places(before: Room, after: Room) -> Float64:
    """Return the middles (N, 3) of the boxes that are only in one of the two rooms."""
    old, new = _changed_ids(before, after)
    places = [world_box(before.thing(i)).mean(0) for i in old]
    places += [world_box(after.thing(i)).mean(0) for i in new]
    if not places:
        raise ValueError(f"{before.kind} {before.seed}: nothing in the room can be changed")
    return np.stack(places)
