"""The truth of a rendered recording: its depth with the exact ``frame-NNNNNN.instance.png``.

Every pixel within reach is put into the world by the recorded depth, noise included, and votes
for what its voxel is; see ``SurfaceVotes``. Of a scene that changes only the end counts: a thing
has the votes of the frames since it stands where it stands at the end, and one that is gone has
none. Wall, floor and pixels of nothing (0) are evaluation points too, and unannotated.
"""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

from sceneq_core.arrays import Array, Bool, Int64
from sceneq_core.evaluation.surface_votes import SurfaceVotes, SurfaceVotesParams
from sceneq_core.frame import depth_from_mm
from sceneq_core.ingest.source import RawFrame, Skipped
from sceneq_nodes._folder_source import FolderParams, FolderSource
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation.true_things import THINGS_FILE, TrueThing, read_things
from sceneq_tools.evaluation.truth import Truth, truth_of_things

NOTHING = 0


def is_rendered(path: Path) -> bool:
    """Tell whether ``path`` is a recording with truth."""
    return (path / THINGS_FILE).is_file() and any(path.glob("frame-*.instance.png"))


def read_rendered(
    folder: Path,
    params: SurfaceVotesParams | None = None,
    before_frame: int | None = None,
    step: int = 1,
) -> Truth:
    """Return the truth at the end of a rendered recording, or just before one of its frames.

    Only every ``step``-th frame votes: the truth about the surface that those show.

    Raises:
        UserError: a file that is missing or malformed; it is named.
    """
    things = read_things(folder / THINGS_FILE, before_frame)
    votes = SurfaceVotes(params)
    source = _open(folder, step)
    for raw in source.frames():
        if isinstance(raw, Skipped):
            raise UserError(f"{raw.where}: {raw.reason}", 2)
        if before_frame is not None and raw.seq >= before_frame:
            break
        _vote(votes, source, raw, instance_image(folder, raw.seq), things)
    points_world, number = votes.points()
    named = {thing.id: thing.names for thing in things if not thing.is_stuff}
    spacing_cm = 100 * votes.params.voxel_m
    shown = f", step {step}" if step > 1 else ""
    return truth_of_things(points_world, number, named, f"{folder} ({spacing_cm:g} cm{shown})")


def _open(folder: Path, step: int) -> FolderSource:
    try:
        source = FolderSource(FolderParams(str(folder), step=step))
    except ValueError as error:
        raise UserError(str(error), 2) from error
    if not source.has_poses:
        raise UserError(f"{folder}: no frame-*.pose.txt", 2)
    if source.color_camera is not source.depth_camera:
        raise UserError(f"{folder}: depth is not registered to colour and so to instance.png", 2)
    return source


def _vote(
    votes: SurfaceVotes,
    source: FolderSource,
    raw: RawFrame,
    shown: Int64,
    things: Sequence[TrueThing],
) -> None:
    depth_mm = raw.read_depth_mm()
    if isinstance(depth_mm, Skipped):
        raise UserError(f"{depth_mm.where}: {depth_mm.reason}", 2)
    if shown.shape != depth_mm.shape:
        raise UserError(
            f"instance.png of frame {raw.seq}: {shown.shape}, depth {depth_mm.shape}", 2
        )
    assert raw.T_world_camera is not None  # the source has poses
    number, may_vote = _ballot(int(shown.max(initial=0)), raw.seq, things)
    K, T_world_camera = source.depth_camera.K, raw.T_world_camera
    votes.add(depth_from_mm(depth_mm), number[shown], may_vote[shown], K, T_world_camera)


def _ballot(highest: int, frame: int, things: Sequence[TrueThing]) -> tuple[Int64, Bool]:
    """Return, for every id in an image, what it votes for and whether it may."""
    count = max([highest, *(thing.id for thing in things)]) + 1
    number, may_vote = np.full(count, NOTHING, np.int64), np.ones(count, bool)
    for thing in things:
        number[thing.id] = NOTHING if thing.is_stuff else thing.id
        may_vote[thing.id] = thing.since_frame is not None and frame >= thing.since_frame
    return number, may_vote


def instance_image(folder: Path, frame: int) -> Int64:
    """Return the ids of a frame, int64 (H, W); ``UserError`` names an unusable file."""
    path = folder / f"frame-{frame:06d}.instance.png"
    image: Array | None = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise UserError(f"{path}: missing or no image", 2)
    if image.ndim != 2 or image.dtype not in (np.uint8, np.uint16):
        raise UserError(f"{path}: expected grey uint16 (H, W), got {image.dtype} {image.shape}", 2)
    return image.astype(np.int64)
