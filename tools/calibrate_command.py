"""``sceneq calibrate``: the probabilities of an encoder, from recordings with truth."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.evaluation.calibration_command import Recordings
from sceneq_tools.evaluation.retrieval_command import GraphFile
from sceneq_tools.progress import Quiet

if TYPE_CHECKING:
    from sceneq_tools.evaluation.calibration_fit import Fitted


def run(
    recordings: Recordings,
    out: Annotated[
        Path, typer.Option("--out", metavar="FILE", help="A folder: named by the encoder's id.")
    ] = Path("calibration.json"),
    graph: GraphFile = None,
    fit_on: Annotated[
        str, typer.Option("--fit", help="T fits questions, labels or both.")
    ] = "questions",
    maps: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER", help="Where the maps are kept; default: made and thrown away."
        ),
    ] = None,
    true_only: Annotated[
        bool, typer.Option("--true-only", help="Do not fit on maps: faster, and too bold on them.")
    ] = False,
    strangers: Annotated[
        Path | None,
        typer.Option(
            metavar="FOLDER",
            help="Of probes by sceneq train-probe --withhold: fit for unknown furniture, too.",
        ),
    ] = None,
    date: Annotated[
        str, typer.Option(help="Written into the file as it is, such as 2026-11-22.")
    ] = "",
    quiet: Quiet = False,
) -> None:
    """Fit temperature, "none of them" and gate on recordings with truth; test on others.

    On their true instances and on maps that are made of them, each asked the same questions. With
    strangers once more as described by a probe that was not taught with the model of each thing,
    for scenes that look unlike what the encoder knows. Of a suite the tuning rooms are used. The
    file goes into the graph: nodes, routing, params, calibration: calibration.json
    """
    from tempfile import TemporaryDirectory

    from sceneq_tools.errors import UserError
    from sceneq_tools.evaluation.calibration_fit import TASKS, fit
    from sceneq_tools.evaluation.calibration_material import Material
    from sceneq_tools.evaluation.retrieval_setup import open_setup
    from sceneq_tools.evaluation.strangers import open_strangers
    from sceneq_tools.evaluation.suite_maps import MapOptions

    if fit_on not in TASKS:
        raise UserError(f"--fit {fit_on!r}: expected one of {', '.join(TASKS)}", 2)
    setup = open_setup(graph)
    with TemporaryDirectory(prefix="sceneq-maps-") as passing:
        options = MapOptions(maps or Path(passing), graph)
        material = Material(recordings, options, true_only, quiet)
        others = open_strangers(strangers, graph, Path(passing)) if strangers else []
        known = material.known(setup)
        strange = material.strange(known, setup, others)
    try:
        fitted = fit(known.true, setup, fit_on, known.maps, strange)
    except ValueError as error:
        raise UserError(f"nothing to fit to: {error}") from error
    _write(fitted, [scene.questioned.name for scene in known.maps], date, out)


def _write(fitted: "Fitted", maps: list[str], date: str, out: Path) -> None:
    """Write a calibration, into a folder by the id of its encoder, and print what it is."""
    from sceneq_tools.json_file import write_json

    calibration = fitted.calibration
    file = out / f"{calibration.encoder}.json" if out.is_dir() else out
    write_json({**fitted.as_dict(), "maps": maps, "date": date}, file)
    _print(fitted)
    typer.echo(f"{calibration.name} -> {file}")


def _print(fitted: "Fitted") -> None:
    """Print the measures before and after, and all numbers."""
    from sceneq_tools.evaluation.calibration_command import print_calibration

    for name, report in (("before", fitted.before), ("after", fitted.after)):
        typer.echo(f"{name}, on the true instances that it was fitted on")
        print_calibration(report)
    calibration = fitted.calibration
    typer.echo(f"T {calibration.temperature:g}, {calibration.gate}")
    typer.echo(f"named: {calibration.null}")
    sureness = calibration.sureness_described
    typer.echo(f"described: {calibration.null_described or 'as named'}, {sureness or 'as it is'}")
    typer.echo(f"unfamiliar: {calibration.unfamiliar or 'as all'}")
