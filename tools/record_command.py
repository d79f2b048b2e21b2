"""``sceneq record``: a running graph into a file that can be played again."""

from pathlib import Path
from typing import Annotated

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint


def run(
    out: Annotated[Path, typer.Argument(metavar="OUT.mcap", help="File to write.")],
    masks: Annotated[
        bool, typer.Option("--masks", help="The 2D segments of every keyframe as well.")
    ] = False,
    no_map: Annotated[
        bool, typer.Option("--no-map", help="Frames, poses and answers only.")
    ] = False,
    max_mb: Annotated[
        int, typer.Option(min=0, metavar="N", help="End after N MB; 0 = when the disk is full.")
    ] = 0,
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Record frames, poses, map and answers until Ctrl-C (docs/recordings.md).

    From the first frame on: sceneq up --record OUT.mcap.
    """
    from sceneq_nodes._launch import Launch
    from sceneq_nodes._process import run_alone
    from sceneq_tools.errors import UserError
    from sceneq_tools.joining import join
    from sceneq_tools.record_option import RECORDER, need_new_file

    need_new_file(out)
    params = {"path": str(out.resolve()), "masks": masks, "map": not no_map, "max_mb": max_mb}
    try:
        code = run_alone(Launch(RECORDER, join(RECORDER, scene, connect), params, connect))
    except ValueError as error:
        raise UserError(str(error), 2) from error
    raise typer.Exit(code)
