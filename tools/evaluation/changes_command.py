"""``sceneq eval changes``: does the map follow a room that people change?"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.evaluation.retrieval_command import GraphFile, JsonFile
from sceneq_tools.progress import Quiet
from sceneq_tools.up_command import Segmenter

if TYPE_CHECKING:
    from sceneq_core.evaluation.scene_changes import Fate
    from sceneq_tools.evaluation.changes import CutReport

COLUMNS = ("thing", "what happened", "known", "IoU before", "IoU after", "same id", "ghost")


def run(
    recording: Annotated[
        Path, typer.Argument(metavar="RECORDING", help="Rendered recording of a changing room.")
    ],
    graph: GraphFile = None,
    segmenter: Segmenter = None,
    step: Annotated[
        int | None, typer.Option(min=1, help="Put every Nth frame into the map.")
    ] = None,
    json_file: JsonFile = None,
    quiet: Quiet = False,
) -> None:
    """Map a recording and say of every edit, and of what stayed, whether the map knows."""
    from sceneq_tools.evaluation.changes import Changes
    from sceneq_tools.json_file import write_json
    from sceneq_tools.map_plan import map_plan
    from sceneq_tools.playing import play

    changes = Changes(recording, map_plan(recording, graph, step=step, segmenter=segmenter))
    try:
        play(changes.stages(), quiet)
        reports = changes.reports()
    finally:
        changes.close()
    names = changes.history.names
    for report in reports:
        _print(report, names)
    if json_file is not None:
        cuts = [report.as_dict(names) for report in reports]
        write_json({"recording": recording.name, "step": step, "cuts": cuts}, json_file)


def _print(report: "CutReport", names: dict[int, str]) -> None:
    from sceneq_tools.table import print_table

    lost = [fate for fate in report.stayed if not fate.is_known]
    shown = [_row(fate, names) for fate in (*report.edits, *lost)]
    print_table(COLUMNS, shown, f"frame {report.frame}")
    known = sum(fate.is_known for fate in report.edits)
    kept = sum(fate.kept_id for fate in report.stayed)
    typer.echo(
        f"{known} of {len(report.edits)} edits known; of {len(report.stayed)} things found before "
        f"that stayed, {len(lost)} lost, {kept} with the same id"
    )


def _row(fate: "Fate", names: dict[int, str]) -> tuple[str, ...]:
    return (
        names[fate.thing],
        fate.kind,
        "yes" if fate.is_known else "no",
        f"{fate.before[1]:.2f}",
        f"{fate.after[1]:.2f}",
        "yes" if fate.kept_id else "no",
        f"{fate.ghost:.2f}",
    )
