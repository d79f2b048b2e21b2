"""What our command line makes of words, without doing anything."""

import typer
import typer.main

from sceneq_tools.cli import app

UNFINISHED = ("MissingParameter", "NoArgsIsHelpError")
"""A command that is only named, without what it needs, is right too."""


def parsed(words: list[str]) -> dict[str, object]:
    """Return the parameters that ``sceneq WORDS`` has; raise what typer raises at a wrong word."""
    command, name = typer.main.get_command(app), "sceneq"
    context = None
    words = [word for word in words if word != "--help"]
    while True:
        try:
            context = command.make_context(name, list(words), parent=context)
        except typer.TyperException as error:
            if type(error).__name__ in UNFINISHED or "requires an argument" in str(error):
                return {}
            raise
        if not hasattr(command, "resolve_command"):
            return context.params
        rest = [*context._protected_args, *context.args]
        if not rest:
            return {}
        name, command, words = command.resolve_command(context, rest)
