"""``sceneq map``: a recording to a map in one process, by the same nodes and without a network."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.export_command import Rrd, write_all
from sceneq_tools.progress import Quiet
from sceneq_tools.up_command import NoPoses, Scene, Segmenter

if TYPE_CHECKING:
    pass


MapStep = Annotated[
    int | None,
    typer.Option(min=1, help="Put every Nth frame into the map; default: as the graph says."),
]

ProposalFile = Annotated[
    Path | None, typer.Option(help="3D masks in place of our own: .npz (docs/proposals.md).")
]


def run(
    source: Annotated[Path, typer.Argument(help="Frames, or a ScanNet, Replica or TUM folder.")],
    out: Annotated[Path, typer.Argument(help="Folder to write into.")],
    graph: Annotated[
        Path | None, typer.Option(help="Default: ./graph.yaml, else the one in the package.")
    ] = None,
    scene: Scene = None,
    step: MapStep = None,
    no_poses: NoPoses = False,
    segmenter: Segmenter = None,
    proposals: ProposalFile = None,
    rrd: Rrd = False,
    report: Annotated[
        bool, typer.Option("--report", help="Compare estimated with given poses.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Write instances.npz, instances.json, cloud.ply and instances.png of a recording."""
    from sceneq_tools.batch import Batch
    from sceneq_tools.collect import collect
    from sceneq_tools.map_plan import map_plan
    from sceneq_tools.playing import play

    batch = Batch(map_plan(source, graph, scene, step, no_poses, segmenter, proposals))
    try:
        play(batch.stages(), quiet)
        write_all(collect(batch.get, batch.scene), out, rrd)
        for name, count in sorted(batch.troubles().items()):
            typer.echo(f"{name}: {count}")
        if report:
            typer.echo(batch.trajectory_report())
    finally:
        batch.close()
