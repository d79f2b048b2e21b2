"""``sceneq eval ablation --policies``: which questions are worth the reasoner?"""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import typer

from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.policy_chart import chart
from sceneq_tools.evaluation.policy_curve import PROTOCOL, Curve, curve
from sceneq_tools.evaluation.policy_outcomes import outcomes_of
from sceneq_tools.evaluation.policy_replay import ADAPTIVE, ALWAYS, NEVER, THRESHOLDS, Replayed
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.json_file import write_json
from sceneq_tools.scene_picture import write_png
from sceneq_tools.table import print_table

ORDERS, SEED = 10, 0
COLUMNS = ("policy", "setting", "calls/question", "right", "beside random", "foresight", "refused")
PAPER = "x 1"


def curves_of(scenes: Sequence[Scene], setup: Setup, accuracies: Sequence[float]) -> list[Curve]:
    """Return one curve with the graph's reasoner and one a simulated accuracy."""
    own = type(setup.reasoner).__name__
    kinds: list[tuple[str, float | None]] = [(own, None)]
    kinds += [(f"simulated model, right {100 * one:.0f} %", one) for one in accuracies]
    return [
        curve(name, outcomes_of(scenes, setup, accuracy, SEED), ORDERS, SEED)
        for name, accuracy in kinds
    ]


def tell(curves: Sequence[Curve]) -> None:
    """Print a table a curve, whether selecting is worth it, and lines for the graph."""
    for one in curves:
        rows = [_row(one, point) for point in one.points]
        print_table(COLUMNS, rows, f"{one.reasoner}, {one.questions} questions")
        typer.echo(_verdict(one))
        typer.echo(_for_graph(one))
    typer.echo(PROTOCOL)


def save(
    curves: Sequence[Curve],
    scenes: Sequence[Scene],
    setup: Setup,
    json: Path | None,
    png: Path | None,
) -> None:
    """Write what was asked for."""
    if json is not None:
        names = [scene.questioned.name for scene in scenes]
        told = [one.as_dict() for one in curves]
        head = {**setup.named(), "protocol": PROTOCOL, "orders": ORDERS, "seed": SEED}
        write_json({**head, "recordings": names, "curves": told}, json)
    if png is not None:
        write_png(chart(curves), png)


def _row(one: Curve, point: Replayed) -> tuple[str, ...]:
    return (
        point.contender.policy,
        point.contender.setting,
        f"{point.cost:.3f}",
        f"{100 * point.accuracy:.1f} %",
        f"{100 * one.beside_random(point):+.1f}",
        f"{100 * one.foresight(point.cost):.1f} %",
        f"{100 * point.refused:.0f} %",
    )


def _verdict(one: Curve) -> str:
    """Say whether selecting is at least as right as never and always asking."""
    best = max(one.point(NEVER).accuracy, one.point(ALWAYS).accuracy)
    said = []
    for name, point in (
        ("thresholds", one.point(THRESHOLDS, PAPER)),
        ("adaptive", one.point(ADAPTIVE, "no limit")),
    ):
        said.append(f"{name} {100 * (point.accuracy - best):+.1f} at {point.cost:.2f} calls")
    return f"beside the better of never and always: {', '.join(said)}"


def _for_graph(one: Curve) -> str:
    """Return the measured skills as parameters of the routing node."""
    skills = (
        f"{kind}: {{{', '.join(f'{name}: {value:.2f}' for name, value in asdict(skill).items())}}}"
        for kind, skill in one.skills.items()
    )
    return f"policy: {{kind: adaptive, outlook: {{{', '.join(skills)}}}}}\n"
