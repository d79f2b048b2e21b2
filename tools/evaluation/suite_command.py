"""``sceneq eval suite``: everything there is to measure, in one report."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sceneq_tools.evaluation.retrieval_command import CalibrationFile, GraphFile
from sceneq_tools.progress import Quiet

if TYPE_CHECKING:
    from sceneq_tools.evaluation.report_tables import Table

DEFAULT_FOLDER, DEFAULT_OUT = "suite", "report"
SEGMENTERS = ("rgbd", "files")


def run(
    folders: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[FOLDER...]",
            help="Suites, and recordings with truth and questions.  [default: suite]",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder to write the report into.")] = Path(DEFAULT_OUT),
    segmenter: Annotated[
        str | None, typer.Option(help="rgbd, or files = masks beside the frames.")
    ] = None,
    every: Annotated[
        int | None,
        typer.Option(
            min=1, help="Each so-manieth frame is a keyframe; default: as suite and graph say."
        ),
    ] = None,
    graph: GraphFile = None,
    calibration: CalibrationFile = None,
    cache: Annotated[
        Path | None, typer.Option(help="Where maps are kept; default: OUT/maps.")
    ] = None,
    fresh: Annotated[
        bool, typer.Option("--fresh", help="Make the maps again that are there already.")
    ] = False,
    quiet: Quiet = False,
) -> None:
    """Map recordings; measure instances, retrieval, calibration, reasoning; write one report.

    Calibration is fitted on the tuning rooms of a suite, and measured on everything else.
    """
    from sceneq_tools.errors import UserError
    from sceneq_tools.evaluation.report import PAGE_FILE, make_report, write_report
    from sceneq_tools.evaluation.retrieval_setup import open_setup
    from sceneq_tools.evaluation.suite_maps import MapOptions
    from sceneq_tools.evaluation.suite_recordings import recordings_of

    if segmenter is not None and segmenter not in SEGMENTERS:
        raise UserError(f"--segmenter {segmenter!r}: expected {' or '.join(SEGMENTERS)}", 2)
    recordings = recordings_of(folders or [Path(DEFAULT_FOLDER)], every)
    setup = open_setup(graph, calibration)
    options = MapOptions(cache or out / "maps", graph, segmenter, fresh)
    document, evaluation = make_report(recordings, setup, options, _command(), quiet)
    write_report(document, evaluation, out)
    for table in _tables(document):
        _print(table)
    typer.echo(f"{len(recordings)} recordings in {document['took_s'] / 60:.1f} min")
    typer.echo(f"-> {out / PAGE_FILE}")


def _command() -> str:
    """Return what was typed."""
    import shlex

    return shlex.join(["sceneq", *sys.argv[1:]])


def _tables(document: dict[str, Any]) -> "list[Table]":
    from sceneq_tools.evaluation import report_tables as tables

    return [
        tables.instances_by_split(document["instances"]),
        tables.instances_by_recording(document["recordings"]),
        tables.retrieval(document["retrieval"]),
        tables.routes(document["retrieval"]),
        *map(tables.calibration, document["calibration"]),
        *(tables.sensitivity(one["routing"]) for one in document["calibration"]),
        tables.ablation(document["ablation"]),
        tables.summary(document),
    ]


def _print(table: "Table") -> None:
    from sceneq_tools.table import print_table

    typer.echo(table.title)
    print_table(table.columns, table.rows)
