"""``sceneq chaos``: harm a running graph in every way there is, and tell what was lost."""

import signal
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from sceneq_tools.chaos.scenario import Outcome

COLUMNS = ("fault", "times", "lost", "", "detail", "again with")


def run(
    scenario: Annotated[
        list[str] | None, typer.Argument(metavar="SCENARIO", help="Default: all of them.")
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Other moments, other damage.")] = 0,
    count: Annotated[int, typer.Option(min=1, help="Damaged inputs of the fuzz.")] = 200_000,
    short: Annotated[bool, typer.Option("--short", help="A minute instead of ten.")] = False,
    names: Annotated[bool, typer.Option("--list", help="Only list the scenarios.")] = False,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Also write the table as JSON.")
    ] = None,
) -> None:
    """Kill, hang, cut off, fill up, flood and fuzz; exit code 1 when anything was lost."""
    from sceneq_tools.chaos.registry import SCENARIOS, SHORT
    from sceneq_tools.chaos.running import as_json, outcomes, rows
    from sceneq_tools.errors import UserError
    from sceneq_tools.json_file import write_json
    from sceneq_tools.table import print_table

    if names:
        typer.echo("\n".join(SCENARIOS))
        return
    if unknown := [name for name in scenario or () if name not in SCENARIOS]:
        raise UserError(f"no scenario named {unknown[0]!r} (there are: {', '.join(SCENARIOS)})", 2)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # the graphs are to end with us
    usual = list(SHORT if short else SCENARIOS)
    done: dict[str, list[Outcome]] = {}
    for name, outcome in outcomes(scenario or usual, seed, short, count):
        done.setdefault(name, []).append(outcome)
        typer.echo(f"{outcome.verdict:8}{outcome.fault}", err=True)
    print_table(COLUMNS, rows(done, seed, count))
    if json_file is not None:
        write_json(as_json(done, seed, count), json_file)
    failed = [one.fault for found in done.values() for one in found if not one.passed]
    if failed:
        raise UserError(f"{len(failed)} faults did harm: {', '.join(failed[:8])}")
