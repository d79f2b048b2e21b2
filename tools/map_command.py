"""``sceneq map``: a recording to a map in one process, by the same nodes and without a network."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.export_command import Rrd, write_all
from sceneq_tools.progress import Quiet, progress
from sceneq_tools.up_command import NoPoses, Scene, Segmenter, source_overrides

if TYPE_CHECKING:
    from sceneq_tools.batch import Batch
    from sceneq_tools.graph_plan import Plan


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

    batch = Batch(map_plan(source, graph, scene, step, no_poses, segmenter, proposals))
    try:
        _show_progress(batch, quiet)
        write_all(collect(batch.get, batch.scene), out, rrd)
        for name, count in sorted(batch.troubles().items()):
            typer.echo(f"{name}: {count}")
        if report:
            typer.echo(batch.trajectory_report())
    finally:
        batch.close()


def map_plan(
    source: Path,
    graph: Path | None = None,
    scene: str | None = None,
    step: int | None = None,
    no_poses: bool = False,
    segmenter: str | None = None,
    proposals: Path | None = None,
) -> "Plan":
    """Return the nodes that make a map of ``source``; ``UserError`` when they cannot."""
    from sceneq_tools.graph import Override, default_path, load
    from sceneq_tools.graph_check import check_nodes
    from sceneq_tools.graph_plan import plan

    # Rate 0: the next frame is read when the last one is in the map.
    overrides = source_overrides(source, scene, 0.0, None, False, no_poses, segmenter)
    if step is not None:
        every = {"kind": "every", "every": step}
        overrides.append(Override("ingest", ("keyframes",), every, "--step"))
    if proposals is not None:
        masks = {"kind": "file", "path": str(proposals.resolve())}
        overrides.append(Override("mapping", ("proposals",), masks, "--proposals"))
    loaded, document = load(graph or default_path(), overrides)
    check_nodes(loaded, document)
    return plan(loaded, document, "local")


def _show_progress(batch: "Batch", quiet: bool) -> None:
    for stage in batch.stages():
        with progress(stage.name, stage.total, quiet=quiet) as advance:
            before = 0
            for done in stage.steps:
                advance(done - before)
                before = done
