"""``sceneq eval calibration``: do the probabilities mean what they say?"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.evaluation.retrieval_command import (
    CalibrationFile,
    GraphFile,
    JsonFile,
    told,
    true_of,
)
from sceneq_tools.progress import Quiet

if TYPE_CHECKING:
    from sceneq_core.evaluation.gate_decisions import F1
    from sceneq_tools.evaluation.calibration import (
        CalibrationReport,
        RoutingScores,
        Scene,
        TaskScores,
    )
    from sceneq_tools.evaluation.calibration_claims import Claims
    from sceneq_tools.evaluation.retrieval_setup import Setup

COLUMNS = (
    *("guesses", "n", "right", "mean p", "NLL", "Brier", "top Brier"),
    *("ECE width/mass", "by chance", "beyond", "90 %"),
    *("AURC (least)", "AUROC p", "margin", "entropy"),
)
GATE_COLUMNS = ("threshold", "x 0.9", "x 1", "x 1.1")

Recordings = Annotated[
    list[Path],
    typer.Argument(
        metavar="RECORDING",
        help="Rendered, with queries and truth; of suites a split of the rooms.",
    ),
]


def run(
    recordings: Recordings,
    graph: GraphFile = None,
    calibration: CalibrationFile = None,
    json_file: JsonFile = None,
    quiet: Quiet = False,
) -> None:
    """Measure confidence and the gate's decisions on the true instances of recordings."""
    from sceneq_tools.evaluation.calibration import evaluate_calibration
    from sceneq_tools.evaluation.retrieval_setup import open_setup
    from sceneq_tools.json_file import write_json

    setup = open_setup(graph, calibration)
    scenes = read_scenes(recordings, setup, quiet)
    report = evaluate_calibration(scenes, setup)
    seen = tuned_on(scenes, setup)
    typer.echo(f"calibration in {', '.join(report.recordings)}: {told(setup)}")
    if seen:
        typer.echo(f"fitted on these very data, so too good: {', '.join(seen)}")
    print_calibration(report)
    if json_file is not None:
        write_json({**setup.named(), "fitted_on": seen, **report.as_dict()}, json_file)


def read_scenes(
    recordings: Sequence[Path], setup: "Setup", quiet: bool, split: str = "test"
) -> "list[Scene]":
    """Return the questions and true instances of every recording.

    A suite stands for its rooms of ``split``, seen as often as it says.
    """
    from sceneq_tools.evaluation.calibration import Scene
    from sceneq_tools.evaluation.retrieval_queries import read_questioned

    chosen = [one for path in recordings for one in _rooms(path, split)]
    read = [(read_questioned(path), setup.seeing(every)) for path, every in chosen]
    return [Scene(questioned, true_of(questioned, seeing, quiet)) for questioned, seeing in read]


def _rooms(path: Path, split: str) -> list[tuple[Path, int | None]]:
    """Return the recordings that a path stands for, and which frames are keyframes."""
    from sceneq_tools.evaluation.suite_recordings import recordings_of
    from sceneq_tools.suite import is_suite

    if not is_suite(path):
        return [(path, None)]
    found = recordings_of([path])
    return [(one.folder, one.every) for one in found if one.split == split]


def tuned_on(scenes: "Sequence[Scene]", setup: "Setup") -> list[str]:
    """Return the recordings that the calibration was fitted on."""
    known = setup.calibration.sha256 if setup.calibration else ()
    return [one.questioned.name for one in scenes if one.questioned.sha256 in known]


def print_calibration(report: "CalibrationReport") -> None:
    """Print the measures with their protocols, and the gate's decisions."""
    from sceneq_tools.evaluation.calibration import PROTOCOL, ROUTED, ROUTING
    from sceneq_tools.evaluation.calibration_claims import CLAIMS
    from sceneq_tools.table import print_table

    print_table(COLUMNS, [_row(task) for task in report.tasks], f"T {report.temperature:g}")
    for line in dict.fromkeys(task.task for task in report.tasks):
        typer.echo(line)
    typer.echo(PROTOCOL)
    typer.echo("")
    routing = report.routing
    seen = f"{routing.decisions} questions, {routing.right} first guesses right"
    typer.echo(f"routing {_decided(routing.f1)} of {seen}")
    typer.echo(f"as routed {_decided(routing.as_routed)} of {routing.questions} questions")
    typer.echo(_claimed(routing.claims))
    typer.echo(ROUTING)
    typer.echo(ROUTED)
    typer.echo(CLAIMS)
    title = "routing F1 (fast path taken) when one threshold is scaled"
    print_table(GATE_COLUMNS, _sensitivity_rows(report.routing), title)


def _row(task: "TaskScores") -> tuple[str, ...]:
    kind = task.task.partition(":")[0]
    curve = task.curve
    return (
        f"{kind} -> {task.choices}",
        str(task.guesses),
        f"{100 * task.accuracy:.0f} %",
        f"{task.confidence:.3f}",
        f"{task.nll:.3f}",
        f"{task.brier:.3f}",
        f"{task.top_brier:.3f}",
        f"{task.ece_width:.3f}/{task.ece_mass:.3f}",
        f"{task.ece_noise:.3f} (in {100 * task.ece_as_much:.0f} %)",
        f"{task.ece_beyond:.3f}",
        "{:.3f} to {:.3f}".format(*task.ece_interval),
        f"{curve.area:.3f} ({curve.least_area:.3f})",
        *(_share(task.auroc[name]) for name in ("p_max", "margin", "entropy")),
    )


def _decided(score: "F1") -> str:
    return (
        f"F1 {score.f1:.3f}: precision {score.precision:.3f}, recall {score.recall:.3f}, "
        f"fast path taken for {100 * score.accepted:.0f} %"
    )


def _claimed(claims: "Claims") -> str:
    auroc = _share(claims.absence_auroc)
    return (
        f"claims of {claims.questions}: {claims.found} found, {claims.found_right} of them right "
        f"(risk {100 * claims.risk:.0f} %); {claims.not_found} not found, "
        f"{claims.not_found_right} of them right; AUROC of {claims.absent} absent {auroc}"
    )


def _sensitivity_rows(routing: "RoutingScores") -> list[tuple[str, ...]]:
    names = dict.fromkeys(row.threshold for row in routing.sensitivity)
    return [
        (
            f"{name} {getattr(routing.gate, name):g}",
            *(
                f"{row.score.f1:.3f} ({100 * row.score.accepted:.0f} %)"
                for row in routing.sensitivity
                if row.threshold == name
            ),
        )
        for name in names
    ]


def _share(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
