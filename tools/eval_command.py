"""``sceneq eval``: what a map and its answers are worth, against the truth."""

from importlib import import_module
from importlib.util import find_spec

import typer

COMMANDS = ("instances", "changes", "retrieval", "calibration", "ablation", "suite")

app = typer.Typer(
    help="Measure a map and its answers against the truth; every number names its protocol.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


def _register() -> None:
    for name in COMMANDS:
        module = f"sceneq_tools.evaluation.{name}_command"
        if find_spec(module) is not None:
            app.command(name)(import_module(module).run)


_register()
