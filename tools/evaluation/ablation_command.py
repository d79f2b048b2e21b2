"""``sceneq eval ablation``: what reasoning is worth, and what it costs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.evaluation.calibration_command import Recordings
from sceneq_tools.evaluation.retrieval_command import (
    CalibrationFile,
    GraphFile,
    JsonFile,
    percent,
    told,
)
from sceneq_tools.progress import Quiet

if TYPE_CHECKING:
    from sceneq_tools.evaluation.ablation import Ablation
    from sceneq_tools.evaluation.retrieval import Retrieval


def run(
    recordings: Recordings,
    graph: GraphFile = None,
    calibration: CalibrationFile = None,
    json_file: JsonFile = None,
    policies: Annotated[
        bool, typer.Option("--policies", help="Compare policies: cost-accuracy curves.")
    ] = False,
    simulated: Annotated[
        list[float] | None,
        typer.Option(min=0.0, max=1.0, help="With --policies: accuracy of a simulated model."),
    ] = None,
    png: Annotated[
        Path | None, typer.Option(metavar="FILE", help="With --policies: draw the curves.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Answer the questions of recordings without, with selective and with constant reasoning."""
    from sceneq_tools.evaluation.ablation import evaluate_ablation
    from sceneq_tools.evaluation.calibration_command import read_scenes
    from sceneq_tools.evaluation.policies import curves_of, save, tell
    from sceneq_tools.evaluation.retrieval_setup import open_setup
    from sceneq_tools.json_file import write_json

    setup = open_setup(graph, calibration)
    scenes = read_scenes(recordings, setup, quiet)
    if policies:
        curves = curves_of(scenes, setup, simulated or ())
        typer.echo(f"policies in {', '.join(one.questioned.name for one in scenes)}: {told(setup)}")
        tell(curves)
        save(curves, scenes, setup, json_file, png)
        return
    ablation = evaluate_ablation(scenes, setup)
    typer.echo(f"ablation in {', '.join(ablation.recordings)}: {told(setup)}")
    print_ablation(ablation)
    if json_file is not None:
        write_json({**setup.named(), **ablation.as_dict()}, json_file)


def print_ablation(ablation: "Ablation") -> None:
    """Print one row per way to reason."""
    from sceneq_tools.evaluation.retrieval import PROTOCOL
    from sceneq_tools.table import print_table

    first = ablation.results[0]
    names = [score.bucket for score in first.buckets]
    columns = ("reasoning", *(f"{name} @1" for name in names), "reasoned", "ms", "VLM calls")
    title = f"{first.candidates} ({first.instances}), hit: {first.hit_rule}"
    print_table(columns, [_row(result) for result in ablation.results], title)
    typer.echo(f"{PROTOCOL}; ms: median, the question read for the first time")


def _row(result: "Retrieval") -> tuple[str, ...]:
    total = result.buckets[-1]
    return (
        result.reasoning,
        *(percent(score.hit_1, score.questions) for score in result.buckets),
        percent(total.reasoned, total.questions),
        f"{total.ms:.1f}",
        str(total.vlm_calls),
    )
