"""``sceneq eval instances``: AP of instances, by the rules of ScanNet200 and of MaskClustering."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from sceneq_core.evaluation.instance_ap import InstanceAp
    from sceneq_core.evaluation.protocol import Protocol
    from sceneq_tools.evaluation.instances import InstancesReport

COLUMNS = (
    "protocol",
    "AP",
    "AP50",
    "AP25",
    "head AP",
    "common AP",
    "tail AP",
    "objects",
    "predicted",
)
CLASS_COLUMNS = ("class", "AP", "AP50", "AP25", "objects", "predicted")
SCORES = ("p", "equal")
SPLITS = ("head", "common", "tail")
ABSENT = "-"


def run(
    prediction: Annotated[
        Path, typer.Argument(metavar="PRED", help="Folder of sceneq map, ScanNet text, or many.")
    ],
    truth: Annotated[
        Path, typer.Argument(metavar="GT", help="Rendered recording, ScanNet scene or text, ...")
    ],
    protocol: Annotated[
        list[str] | None,
        typer.Option(
            help="scannet200, own-labels, agnostic or maskclustering; may be repeated. "
            "Default: all."
        ),
    ] = None,
    min_region: Annotated[
        int, typer.Option(min=1, metavar="POINTS", help="The smallest region that counts.")
    ] = 100,
    reach: Annotated[
        float, typer.Option(metavar="M", help="How near a map's point must be, metres.")
    ] = 0.05,
    voxel: Annotated[
        float, typer.Option(metavar="M", help="Spacing of a recording's evaluation points.")
    ] = 0.04,
    truth_step: Annotated[int, typer.Option(min=1, help="Judge by every Nth frame of GT.")] = 1,
    score: Annotated[
        str, typer.Option(help="Of a map's instances: p of the label, or equal for all.")
    ] = "p",
    last_overlap: Annotated[
        float | None,
        typer.Option(help="End of the IoU thresholds; 0.90 in ScanNet's script."),
    ] = None,
    classes: Annotated[bool, typer.Option("--classes", help="Show every class too.")] = False,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write all numbers.")
    ] = None,
) -> None:
    """Print AP of predicted instances against the truth; every number names its protocol.

    PRED and GT may also be folders of many scenes with equal names: they are evaluated together.
    """
    from sceneq_core.evaluation.surface_votes import SurfaceVotesParams
    from sceneq_tools.errors import UserError
    from sceneq_tools.evaluation.instances import InstancesParams, evaluate_instances
    from sceneq_tools.evaluation.readers import scene_pairs
    from sceneq_tools.json_file import write_json

    if score not in SCORES:
        raise UserError(f"--score {score!r}: expected {' or '.join(SCORES)}", 2)
    try:
        protocols = _protocols(protocol, last_overlap)
        votes = SurfaceVotesParams(voxel_m=voxel)
        params = InstancesParams(protocols, min_region, reach, score == "equal", votes, truth_step)
    except ValueError as error:
        raise UserError(str(error), 2) from error
    report = evaluate_instances(scene_pairs(prediction, truth), params)
    _print(report, classes)
    if json_file is not None:
        write_json(report.as_dict(), json_file)


def _protocols(names: list[str] | None, last_overlap: float | None) -> "tuple[Protocol, ...]":
    from sceneq_core.evaluation.protocol import PROTOCOLS

    for name in names or ():
        if name not in PROTOCOLS:
            raise ValueError(f"--protocol {name!r}: expected one of {', '.join(PROTOCOLS)}")
    chosen = [PROTOCOLS[name] for name in names or PROTOCOLS]
    if last_overlap is not None:
        chosen = [one.ending_at(last_overlap) for one in chosen]
    return tuple(chosen)


def _print(report: "InstancesReport", classes: bool) -> None:
    from sceneq_tools.table import print_table

    print_table(COLUMNS, [_row(one) for one in report.results])
    for one in report.results:
        typer.echo(f"{one.protocol.name}: {one.protocol.says}; IoU {_overlaps(one)}")
    typer.echo("")
    for line in _circumstances(report):
        typer.echo(line)
    for one in report.results if classes else ():
        if one.protocol.labels_match:
            print_table(CLASS_COLUMNS, _class_rows(one), f"{one.protocol.name}, by class")


def _circumstances(report: "InstancesReport") -> list[str]:
    params = report.params
    scenes = len(report.truths)
    where = f"at {report.points} points of {report.truths[0]}" if scenes == 1 else (
        f"{scenes} scenes, {report.points} points"
    )  # fmt: skip
    score = "equal for all" if params.constant_score else "p of the label"
    lines = [
        where,
        f"regions of {params.min_region} points or more; a map's points within "
        f"{params.reach_m:g} m; score of a map's instances: {score}",
    ]
    if report.outside:
        lines.append(f"not in ScanNet200, void in scannet200: {', '.join(report.outside)}")
    return lines


def _row(one: "InstanceAp") -> tuple[str, ...]:
    from sceneq_core.evaluation.scannet200_ids import SPLITS as NAMES

    labelled = one.protocol.labels_match
    splits = [one.means_of(NAMES[name])[0] if labelled else float("nan") for name in SPLITS]
    counts = (str(one.objects), str(one.predictions))
    return (one.protocol.name, *map(_shown, (*one.means, *splits)), *counts)


def _class_rows(one: "InstanceAp") -> list[tuple[str, ...]]:
    ranked = sorted(one.classes, key=lambda each: (not each.objects, each.name))
    return [
        (each.name, *map(_shown, each.means), str(each.objects), str(each.predictions))
        for each in ranked
    ]


def _overlaps(one: "InstanceAp") -> str:
    return f"0.50:0.05:{one.protocol.last_overlap:.2f}"


def _shown(value: float) -> str:
    """AP is NaN where there is no object to find."""
    return ABSENT if value != value else f"{value:.3f}"
