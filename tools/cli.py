"""The ``sceneq`` command; each subcommand is a small module that imports its needs when it runs."""

import sys
from importlib import import_module
from importlib.util import find_spec
from typing import Annotated

import typer

COMMANDS = (
    *("up", "ask", "teach", "forget", "status", "metrics", "trace", "view", "viewer", "mcp"),
    *("check", "map", "export", "demo", "schema", "doctor", "bench", "synth", "render"),
    *("record", "replay", "import", "chaos"),
    *("calibrate", "calibrate-names", "portraits", "train-probe"),
)
GROUPS = ("scene", "sim", "eval", "secure")
USAGE = 2
INTERRUPTED = 130

app = typer.Typer(
    name="sceneq",
    help="Ask a robot's live 3D map of object instances questions, with evidence.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"max_content_width": 100},
    rich_markup_mode=None,  # loading rich would take half of the time of --help
)


def main() -> None:
    """Run one command; whatever its user can mend is told in one line on stderr."""
    from sceneq_tools.errors import UserError
    from sceneq_tools.threads import use_one_thread

    use_one_thread()
    try:
        code = app(standalone_mode=False)
    except UserError as error:
        _fail(str(error), error.exit_code)
    except typer.TyperException as error:
        _fail(f"{error.format_message()} (see --help)".replace("\n", " "), USAGE)
    except (typer.Abort, KeyboardInterrupt):
        sys.exit(INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()
        sys.exit(0)
    sys.exit(code if isinstance(code, int) else 0)


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    show_version: Annotated[
        bool, typer.Option("--version", help="Print the version and exit.", is_eager=True)
    ] = False,
) -> None:
    """Ask a robot's live 3D map of object instances questions, with evidence."""
    if show_version:
        from importlib.metadata import version

        typer.echo(f"sceneq {version('sceneq')}")
        raise typer.Exit
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())
        raise typer.Exit(USAGE)


def _fail(message: str, code: int) -> None:
    for line in message.splitlines():
        print(f"sceneq: {line}", file=sys.stderr)
    sys.exit(code)


def _register() -> None:
    for name in COMMANDS:
        module = f"sceneq_tools.{name.replace('-', '_')}_command"
        if find_spec(module) is not None:
            app.command(name)(import_module(module).run)
    for name in GROUPS:
        app.add_typer(import_module(f"sceneq_tools.{name}_command").app, name=name)


_register()
