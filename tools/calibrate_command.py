"""``sceneq calibrate``: the probabilities of an encoder, from recordings with truth."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.evaluation.calibration_command import Recordings
from sceneq_tools.evaluation.retrieval_command import GraphFile
from sceneq_tools.progress import Quiet

if TYPE_CHECKING:
    from sceneq_tools.evaluation.calibration import Scene
    from sceneq_tools.evaluation.retrieval_setup import Setup


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
    date: Annotated[
        str, typer.Option(help="Written into the file as it is, such as 2026-11-22.")
    ] = "",
    quiet: Quiet = False,
) -> None:
    """Fit temperature, "none of them" and gate on recordings with truth; test on others.

    On their true instances and on maps that are made of them, each asked the same questions. Of a
    suite the tuning rooms are used. The file goes into the graph: nodes, routing, params,
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
    scenes = read_scenes(recordings, setup, quiet, TUNING)
    mapped = [] if true_only else _map_scenes(recordings, setup, graph, maps, quiet)
    try:
        fitted = fit(scenes, setup, fit_on, mapped)
    except ValueError as error:
        raise UserError(f"nothing to fit to: {error}") from error
    for name, report in (("before", fitted.before), ("after", fitted.after)):
        typer.echo(f"{name}, on the true instances that it was fitted on")
        print_calibration(report)
    calibration = fitted.calibration
    file = out / f"{calibration.encoder}.json" if out.is_dir() else out
    on_maps = [scene.questioned.name for scene in mapped]
    write_json({**fitted.as_dict(), "maps": on_maps, "date": date}, file)
    typer.echo(f"T {calibration.temperature:g}, {calibration.gate}")
    typer.echo(f"named: {calibration.null}")
    sureness = calibration.sureness_described
    typer.echo(f"described: {calibration.null_described or 'as named'}, {sureness or 'as it is'}")
    typer.echo(f"{calibration.name} -> {file}")


def _map_scenes(
    recordings: list[Path], setup: "Setup", graph: Path | None, maps: Path | None, quiet: bool
) -> "list[Scene]":
    """Return the maps of the recordings, kept in ``maps`` or in a folder that is gone then."""
    from tempfile import TemporaryDirectory

    from sceneq_tools.evaluation.calibration_maps import map_scenes
    from sceneq_tools.evaluation.suite_maps import MapOptions
    from sceneq_tools.suite import TUNING

    with TemporaryDirectory(prefix="sceneq-maps-") as passing:
        options = MapOptions(maps or Path(passing), graph)
        return map_scenes(recordings, TUNING, setup, options, quiet)
