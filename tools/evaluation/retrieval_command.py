"""``sceneq eval retrieval``: does a question find its thing?"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.progress import Quiet, progress

if TYPE_CHECKING:
    from sceneq_tools.evaluation.retrieval import BucketScore, Retrieval
    from sceneq_tools.evaluation.retrieval_candidates import Candidates
    from sceneq_tools.evaluation.retrieval_queries import Questioned
    from sceneq_tools.evaluation.retrieval_setup import Setup

COLUMNS = (
    *("questions", "asked", "Hit@1", "Hit@5", "found", "right of it", "not found"),
    *("fast", "reasoned", "ms", "VLM calls"),
)
THRESHOLDS = (0.5, 0.25)

GraphFile = Annotated[
    Path | None, typer.Option("--graph", help="Default: ./graph.yaml, else that of the package.")
]
CalibrationFile = Annotated[
    Path | None,
    typer.Option("--calibration", metavar="FILE", help="Replaces the graph's; none = none."),
]
JsonFile = Annotated[Path | None, typer.Option("--json", metavar="FILE", help="Write all numbers.")]
Queries = Annotated[
    Path,
    typer.Argument(metavar="QUERIES", help="Rendered recording with queries.json and truth."),
]


def run(
    scene: Annotated[
        Path,
        typer.Argument(metavar="SCENE", help="Folder of sceneq map; the recording: truth only."),
    ],
    queries: Annotated[
        Path | None,
        typer.Argument(metavar="QUERIES", help="Recording with queries.json and truth."),
    ] = None,
    truth: Annotated[
        bool, typer.Option("--truth/--no-truth", help="Ask about the true instances, too.")
    ] = True,
    graph: GraphFile = None,
    calibration: CalibrationFile = None,
    json_file: JsonFile = None,
    quiet: Quiet = False,
) -> None:
    """Ask every question of a recording about a map of it, and about its true instances."""
    from sceneq_tools.evaluation.recording_pictures import pictures_of
    from sceneq_tools.evaluation.retrieval import evaluate_retrieval
    from sceneq_tools.evaluation.retrieval_queries import read_questioned
    from sceneq_tools.evaluation.retrieval_setup import open_setup
    from sceneq_tools.json_file import write_json

    setup = open_setup(graph, calibration)
    questioned = read_questioned(queries or scene)
    pictures = pictures_of(questioned.folder)
    results = [
        result
        for candidates in _candidates(scene, questioned, setup, truth, quiet)
        for result in evaluate_retrieval(candidates, questioned.queries, setup, pictures=pictures)
    ]
    typer.echo(f"retrieval in {questioned.name}: {told(setup)}")
    for result in results:
        print_retrieval(result)
    if json_file is not None:
        write_json(
            {
                "recording": questioned.name,
                "sha256": questioned.sha256,
                **setup.named(),
                "results": [result.as_dict() for result in results],
            },
            json_file,
        )


def _candidates(
    scene: Path, questioned: "Questioned", setup: "Setup", truth: bool, quiet: bool
) -> "list[Candidates]":
    from sceneq_tools.evaluation.map_folder import is_map
    from sceneq_tools.evaluation.rendered_truth import read_rendered
    from sceneq_tools.evaluation.retrieval_candidates import map_candidates

    found = []
    if is_map(scene):
        points = read_rendered(questioned.folder)
        found.append(map_candidates(scene, questioned.folder, points, setup, THRESHOLDS))
    if truth or not found:
        found.append(true_of(questioned, setup, quiet))
    return found


def true_of(questioned: "Questioned", setup: "Setup", quiet: bool) -> "Candidates":
    """Return the true instances of a recording, showing how far their description has come."""
    from sceneq_tools.evaluation.oracle import is_candidate, oracle
    from sceneq_tools.evaluation.retrieval_candidates import true_candidates

    total = sum(map(is_candidate, questioned.things))
    with progress(f"describing {questioned.name}", total, "instances", quiet) as advance:
        return true_candidates(oracle(questioned.folder, setup, advance))


def told(setup: "Setup") -> str:
    """Return one line about what was measured."""
    return ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in setup.named().items())


def print_retrieval(result: "Retrieval") -> None:
    """Print a table with what its numbers mean under it."""
    from sceneq_tools.evaluation.retrieval import PROTOCOL
    from sceneq_tools.table import print_table

    title = (
        f"{result.candidates} ({result.instances}), hit: {result.hit_rule}, "
        f"reasoning: {result.reasoning}"
    )
    print_table(COLUMNS, [_row(score) for score in result.buckets], title)
    typer.echo(f"{PROTOCOL}; ms: median, the question read for the first time")
    unreachable = result.buckets[-1].unreachable
    typer.echo(f"questions without a right candidate, whatever is answered: {unreachable}")
    typer.echo(f"wrongly not found: {result.wrongly_not_found}")


def _row(score: "BucketScore") -> tuple[str, ...]:
    asked = score.questions
    return (
        score.bucket,
        str(asked),
        percent(score.hit_1, asked),
        percent(score.hit_5, asked),
        str(score.found),
        str(score.found_right),
        str(score.not_found),
        percent(score.fast, asked),
        percent(score.reasoned, asked),
        f"{score.ms:.1f}",
        str(score.vlm_calls),
    )


def percent(part: int, of: int) -> str:
    """Return ``67 % (8)``."""
    return f"{100 * part / of:.0f} % ({part})" if of else "-"
