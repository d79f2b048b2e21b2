"""``sceneq demo``: a recording through the real graph, questions meanwhile, then a picture."""

from pathlib import Path
from typing import Annotated

import typer

LIVE_ROOM = "living_room"


def run(
    source: Annotated[
        Path | None, typer.Argument(help="Folder of frames. Default: the sample that comes along.")
    ] = None,
    out: Annotated[Path, typer.Argument(help="Folder to write into.")] = Path("out/demo"),
    question: Annotated[
        list[str] | None, typer.Option("--question", "-q", help="Ask this; repeat for more.")
    ] = None,
    graph: Annotated[
        Path | None, typer.Option(help="Default: ./graph.yaml, else the one in the package.")
    ] = None,
    rate: Annotated[
        float | None, typer.Option(help="Frames a second. Default: as fast as may be.")
    ] = None,
    segmenter: Annotated[
        str | None,
        typer.Option(help="files: label images of the folder (default if it has any), or rgbd."),
    ] = None,
    live: Annotated[
        bool, typer.Option("--live", help="A simulated robot that keeps going until Ctrl-C.")
    ] = False,
    room: Annotated[
        str, typer.Option(help="Of --live: kitchen, living_room, office, bedroom or mixed.")
    ] = LIVE_ROOM,
    seed: Annotated[int, typer.Option(min=0, help="Which of these rooms.")] = 0,
) -> None:
    """Run the graph on a recording, ask while the map grows, write the map and a picture."""
    from sceneq_tools.errors import UserError

    if live and source is not None:
        raise UserError("--live has no recording (say --room ROOM)", 2)
    if live:
        from sceneq_tools.demo_live import run_live

        run_live(room, seed, graph, rate, out)
        return
    from sceneq_tools.demo_recording import Demo, sample

    folder = source or sample()
    Demo(folder, out, question or [], graph, rate or 0.0, segmenter).run()
