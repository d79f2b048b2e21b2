"""What our command line makes of words, without doing anything."""

from functools import cache
from typing import Any

import typer
import typer.main

from sceneq_tools.cli import app

UNFINISHED = ("MissingParameter", "NoArgsIsHelpError")
"""A command that is only named, without what it needs, is right too."""


def parsed(words: list[str]) -> dict[str, object]:
    """Return the parameters that ``sceneq WORDS`` has; raise what typer raises at a wrong word."""
    return _parsed(tuple(words))


@cache
def _parsed(given: tuple[str, ...]) -> dict[str, object]:
    command, name = _root(), "sceneq"
    context = None
    words = [word for word in given if word != "--help"]
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


@cache
def _root() -> Any:
    return typer.main.get_command(app)
