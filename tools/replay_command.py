"""``sceneq replay``: a recording into a graph that runs without a source of its own."""

from pathlib import Path
from typing import Annotated

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint

REPLAY, INGEST = "replay", "ingest"


def run(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Of sceneq record, or a bag.")],
    rate: Annotated[
        float, typer.Option(min=0.0, help="Times as fast as it was; 0 = as fast as it is taken.")
    ] = 1.0,
    seek: Annotated[
        float, typer.Option(min=0.0, metavar="S", help="Leave out the first S seconds.")
    ] = 0.0,
    loop: Annotated[bool, typer.Option("--loop", help="Start again at its end.")] = False,
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Play a recording into a running graph: sceneq up --without ingest --scene NAME."""
    from sceneq_nodes._launch import Launch
    from sceneq_nodes._process import run_alone
    from sceneq_tools.errors import UserError
    from sceneq_tools.joining import join
    from sceneq_tools.replaying import Replay
    from sceneq_tools.up_command import keyframes_of, source_kind

    source = {"kind": source_kind(file), "path": str(file.resolve())}
    if source["kind"] not in ("mcap", "rosbag"):
        raise UserError(f"{file}: no recording in time (play it: sceneq up --source {file})", 2)
    keyframes = keyframes_of(file) or {"kind": "interval"}
    params = {
        "source": {**source, "start_s": seek, "speed": rate, "loop": loop},
        "keyframes": keyframes,
    }
    _need_no_ingest(connect)
    launch = Launch(REPLAY, join(REPLAY, scene, connect), params, connect)
    try:
        code = run_alone(launch, Replay)
    except ValueError as error:
        raise UserError(str(error), 2) from error
    raise typer.Exit(code)


def _need_no_ingest(endpoint: str) -> None:
    """Refuse to speak where the graph's own source does: numbers of frames would collide."""
    from sceneq_tools import scenes
    from sceneq_tools.errors import UserError

    with scenes.connect(endpoint) as client:
        if INGEST in {token["node"] for token in client.alive()}:
            hint = "start it with: sceneq up --without ingest --scene NAME"
            raise UserError(f"the graph has a source of its own ({hint})", 2)
