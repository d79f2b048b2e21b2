"""``sceneq forget``: take a name back."""

import json
from typing import Annotated

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint
from sceneq_tools.teach_command import TIMEOUT_S


def run(
    what: Annotated[str, typer.Argument(metavar="NAME|ID", help="A name, or all of an instance.")],
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="The answer as it came.")] = False,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Take a name back, or all names of an instance; answers are as they were before."""
    from sceneq_schemas.topics import TEACH_FORGET
    from sceneq_tools import scenes
    from sceneq_tools.names_text import forgotten

    request = {"id": int(what)} if what.isdecimal() else {"name": what}
    with scenes.connect(connect) as client:
        name = scenes.need_scene(client, scene)
        body = scenes.ask(client, TEACH_FORGET, name, request, TIMEOUT_S).body
    if as_json:
        typer.echo(json.dumps(body, ensure_ascii=False, indent=2))
    else:
        forgotten(body)
