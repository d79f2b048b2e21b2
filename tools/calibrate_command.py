"""``sceneq calibrate``: the probabilities of an encoder, from recordings with truth."""

from pathlib import Path
from typing import Annotated

import typer

from sceneq_tools.evaluation.calibration_command import Recordings
from sceneq_tools.evaluation.retrieval_command import GraphFile
from sceneq_tools.progress import Quiet


def run(
    recordings: Recordings,
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE", help="A folder: named by the encoder's id.")
    ] = Path("calibration.json"),
    graph: GraphFile = None,
    fit_on: Annotated[
        str, typer.Option("--fit", help="T fits questions, labels or both.")
    ] = "questions",
    date: Annotated[
        str, typer.Option(help="Written into the file as it is, such as 2026-11-22.")
    ] = "",
    quiet: Quiet = False,
) -> None:
    """Fit temperature, "none of them" and gate on the true instances of recordings; test on others.

    Of a suite the tuning rooms are used. The file goes into the graph: nodes, routing, params,
    calibration: calibration.json
    """
    from sceneq_tools.errors import UserError
    from sceneq_tools.evaluation.calibration_command import print_calibration, read_scenes
    from sceneq_tools.evaluation.calibration_fit import TASKS, fit
    from sceneq_tools.evaluation.retrieval_setup import open_setup
    from sceneq_tools.json_file import write_json
    from sceneq_tools.suite import TUNING

    if fit_on not in TASKS:
        raise UserError(f"--fit {fit_on!r}: expected one of {', '.join(TASKS)}", 2)
    setup = open_setup(graph)
    try:
        fitted = fit(read_scenes(recordings, setup, quiet, TUNING), setup, fit_on)
    except ValueError as error:
        raise UserError(f"nothing to fit to: {error}") from error
    for name, report in (("before", fitted.before), ("after", fitted.after)):
        typer.echo(f"{name}, on the data it was fitted on")
        print_calibration(report)
    calibration = fitted.calibration
    file = out / f"{calibration.encoder}.json" if out.is_dir() else out
    write_json({**fitted.as_dict(), "date": date}, file)
    typer.echo(f"T {calibration.temperature:g}, {calibration.null}, {calibration.gate}")
    typer.echo(f"{calibration.name} -> {file}")
