"""``sceneq teach``: give a thing in the map a name."""

import getpass
import json
from enum import StrEnum
from typing import Annotated, Any

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint

TIMEOUT_S = 10.0


class Kind(StrEnum):
    """This one thing only, or all that are like it."""

    individual = "individual"
    category = "category"


def run(
    words: Annotated[
        list[str] | None,
        typer.Argument(metavar="[ID] NAME", help="An instance, unless --view, and its name."),
    ] = None,
    view: Annotated[
        tuple[int, float, float] | None,
        typer.Option(metavar="SEQ X Y", help="What is seen there in keyframe SEQ, pixels."),
    ] = None,
    kind: Annotated[
        Kind | None, typer.Option(help="Default: individual for my, Mary's, Max, 12; else category")
    ] = None,
    by: Annotated[str | None, typer.Option(help="Who says so. Default: you.")] = None,
    list_all: Annotated[bool, typer.Option("--list", help="List what was taught.")] = False,
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="The answer as it came.")] = False,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Give a name: sceneq teach 7 "aunt Mary's mug"; take it back with sceneq forget."""
    from sceneq_schemas.topics import QUERY_NAMES, TEACH_SET
    from sceneq_tools import scenes
    from sceneq_tools.names_text import listed, taught

    if list_all:
        topic, request = QUERY_NAMES, {}
    else:
        topic = TEACH_SET
        request = _request(words or [], view) | {"by": by or getpass.getuser()}
        request |= {"kind": kind.value} if kind else {}
    with scenes.connect(connect) as client:
        name = scenes.need_scene(client, scene)
        body = scenes.ask(client, topic, name, request, TIMEOUT_S).body
    if as_json:
        typer.echo(json.dumps(body, ensure_ascii=False, indent=2))
    elif list_all:
        listed(body)
    else:
        taught(body)


def _request(words: list[str], view: tuple[int, float, float] | None) -> dict[str, Any]:
    from sceneq_tools.errors import UserError

    if view is not None:
        if len(words) != 1:
            raise UserError("with --view SEQ X Y say the name, in quotes, and no ID", 2)
        return {"name": words[0], "view": view[0], "x": view[1], "y": view[2]}
    if len(words) != 2 or not words[0].isdecimal():
        usage = 'say the number of an instance and its name, such as 7 "aunt Mary\'s mug"'
        raise UserError(f"{usage} (numbers: sceneq ask ..., or point with --view SEQ X Y)", 2)
    return {"id": int(words[0]), "name": words[1]}
