"""A run through its stages, with how far it has come."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from sceneq_tools.progress import progress

if TYPE_CHECKING:
    from sceneq_tools.batch import Stage

FRAMES = "frames"


def play(
    stages: "Iterable[Stage]", quiet: bool, title: str = "", most_frames: int | None = None
) -> int:
    """Do all of every stage, of the frames ``most_frames`` at most; return how many were played."""
    played = 0
    for stage in stages:
        most = most_frames if stage.name == FRAMES else None
        with progress(title + stage.name, most or stage.total, quiet=quiet) as advance:
            done = 0
            for now in stage.steps:
                advance(now - done)
                done = now
                if most is not None and done >= most:
                    break
        played = done if stage.name == FRAMES else played
    return played
