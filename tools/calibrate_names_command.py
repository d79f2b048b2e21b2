"""``sceneq calibrate-names``: which look-alikes inherit a name, from recordings with truth."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.evaluation.retrieval_command import GraphFile
from sceneq_tools.progress import Quiet, progress

if TYPE_CHECKING:
    from sceneq_tools.evaluation.likeness import RoomPairs
    from sceneq_tools.evaluation.likeness_fit import LikenessFit, Score
    from sceneq_tools.evaluation.retrieval_setup import Setup

COLUMNS = ("of", "on", "pairs", "same", "log loss", "ECE", "p >= 0.5", "right of it")


def run(
    recordings: Annotated[
        list[Path], typer.Argument(metavar="RECORDING...", help="Made by sceneq synth, or alike.")
    ],
    test: Annotated[
        list[Path] | None, typer.Option(metavar="RECORDING", help="To test on; may be repeated.")
    ] = None,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="What to write.")] = Path(
        "likeness.json"
    ),
    key: Annotated[
        str | None,
        typer.Option("--as", metavar="MODEL", help="May end in *. Default: the encoder's id."),
    ] = None,
    graph: GraphFile = None,
    quiet: Quiet = False,
) -> None:
    """Fit when things are of one category, and when a thing is the same in another map.

    The file goes into the graph: nodes, routing, params, likeness: likeness.json
    """
    from sceneq_tools.errors import UserError
    from sceneq_tools.evaluation.likeness_fit import document, fit_likeness
    from sceneq_tools.evaluation.retrieval_setup import open_setup
    from sceneq_tools.json_file import write_json

    setup = open_setup(graph)
    rooms = _pairs(recordings, setup, quiet)
    try:
        fit = fit_likeness(rooms, _pairs(test or [], setup, quiet))
    except ValueError as error:
        raise UserError(f"nothing to fit to: {error}") from error
    _print(fit)
    write_json(document(fit, key or setup.encoder.model_id, rooms), out)
    typer.echo(f"{out}: for the encoder {key or setup.encoder.model_id}")


def _pairs(folders: list[Path], setup: "Setup", quiet: bool) -> "list[RoomPairs]":
    from sceneq_tools.evaluation.likeness import pairs_in

    found = []
    with progress("measuring", len(folders), "rooms", quiet) as advance:
        for folder in folders:
            found.append(pairs_in(folder, setup))
            advance()
    return found


def _print(fit: "LikenessFit") -> None:
    from sceneq_tools.table import print_table

    measured = (("fitted", fit.fitted), ("tested", fit.tested))
    rows = [_row(part, where, one) for where, scores in measured for part, one in scores.items()]
    print_table(COLUMNS, rows)
    for part, logistic in fit.logistics.items():
        weights = ", ".join(f"{weight:.2f}" for weight in logistic.weights)
        typer.echo(f"{part}: weights {weights}, bias {logistic.bias:.2f}")


def _row(part: str, where: str, one: "Score") -> tuple[str, ...]:
    right = f"{one.right / one.passed:.2f}" if one.passed else "-"
    counts = (str(one.pairs), str(one.same))
    return (part, where, *counts, f"{one.log_loss:.4f}", f"{one.ece:.4f}", str(one.passed), right)
