"""``sceneq sim``: change the room of a running simulation."""

import json
from typing import Annotated, Any

import typer

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"
TIMEOUT_S = 30.0
NAMES = "A name such as 'red mug', or a number from 'sceneq sim list'."

Endpoint = Annotated[str, typer.Option("--connect", help="Router of the graph.")]
Node = Annotated[str, typer.Option(help="Name of the node that reads the simulation.")]
AsJson = Annotated[bool, typer.Option("--json", help="The reply as it came.")]
ThingName = Annotated[str, typer.Argument(metavar="THING", help=NAMES)]
Onto = Annotated[str, typer.Option(metavar="THING", help="Furniture, or 'floor'.")]
Colour = Annotated[str | None, typer.Option("--colour", "--color", help="Such as red.")]

app = typer.Typer(
    help="Change the room of a running simulation (sceneq up --sim office) while it is looked at.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command("list")
def list_things(
    as_json: AsJson = False, node: Node = "ingest", connect: Endpoint = DEFAULT_ENDPOINT
) -> None:
    """Say what is in the room, where, and whether the camera sees it now.

    From any Zenoh client: zenoh get -s 'sceneq/ctl/ingest/list' --decoder json
    """
    reply = control(connect, node, "list", {})
    if as_json:
        _print_json(reply)
        return
    from sceneq_tools.table import print_table

    typer.echo(f"{reply['room']} {reply['seed']}: {len(reply['things'])} things")
    columns = ("id", "thing", "where", "centre m", "pixels now")
    print_table(columns, [_row(thing) for thing in reply["things"]])


@app.command("move")
def move(
    thing: ThingName,
    onto: Onto,
    as_json: AsJson = False,
    node: Node = "ingest",
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Put a thing onto another: sceneq sim move mug --onto "coffee table".

    From any Zenoh client:
    zenoh get -s 'sceneq/ctl/ingest/move?thing=mug;onto=coffee table' --decoder json
    """
    reply = control(connect, node, "move", {"thing": thing, "onto": onto})
    _tell(reply, as_json, f"moved the {reply['was']}: it is {_place(reply)} now")


@app.command("remove")
def remove(
    thing: ThingName,
    as_json: AsJson = False,
    node: Node = "ingest",
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Take a thing away, with what stands on it: sceneq sim remove 17.

    From any Zenoh client: zenoh get -s 'sceneq/ctl/ingest/remove?thing=17' --decoder json
    """
    reply = control(connect, node, "remove", {"thing": thing})
    also = len(reply["gone"]) - 1
    with_it = f", and {also} on it" if also else ""
    _tell(reply, as_json, f"removed the {reply['was']}{with_it}")


@app.command("add")
def add(
    thing: Annotated[str, typer.Argument(metavar="KIND", help="Such as 'teddy bear'.")],
    onto: Onto,
    colour: Colour = None,
    as_json: AsJson = False,
    node: Node = "ingest",
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Put a new thing into the room: sceneq sim add "teddy bear" --onto sofa --colour red.

    From any Zenoh client:
    zenoh get -s 'sceneq/ctl/ingest/add?thing=mug;onto=desk;colour=red' --decoder json
    """
    arguments = {"thing": thing, "onto": onto} | ({"colour": colour} if colour else {})
    reply = control(connect, node, "add", arguments)
    _tell(reply, as_json, f"added a {_called(reply)}, number {reply['id']}: it is {_place(reply)}")


@app.command("look")
def look(
    thing: ThingName,
    as_json: AsJson = False,
    node: Node = "ingest",
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Send the camera to a thing: sceneq sim look mug.

    From any Zenoh client: zenoh get -s 'sceneq/ctl/ingest/look?thing=mug' --decoder json
    """
    reply = control(connect, node, "look", {"thing": thing})
    _tell(reply, as_json, f"the camera goes to the {_called(reply)}, {_place(reply)}")


def control(endpoint: str, node: str, verb: str, arguments: dict[str, str]) -> dict[str, Any]:
    """Return what the simulation says; ``UserError`` when it refuses or nobody answers."""
    from sceneq_schemas.topics import CONTROL
    from sceneq_tools import scenes
    from sceneq_tools.errors import UserError

    payload = json.dumps(arguments).encode()
    with scenes.connect(endpoint) as client:
        key = CONTROL.key(node=node, verb=verb)
        replies, errors = client.get(key, payload, "application/json", TIMEOUT_S)
    if replies:
        return scenes.body(replies[-1][1])
    if errors:
        hint = f" ({errors[0].hint})" if errors[0].hint else ""
        raise UserError(f"{errors[0].message or errors[0].code}{hint}")
    raise UserError("no simulation answers: it is still starting, or start one: sceneq up --sim")


def _tell(reply: dict[str, Any], as_json: bool, sentence: str) -> None:
    _print_json(reply) if as_json else typer.echo(sentence)


def _print_json(reply: dict[str, Any]) -> None:
    typer.echo(json.dumps(reply, ensure_ascii=False, indent=2))


def _called(thing: dict[str, Any]) -> str:
    return f"{thing['colour']} {thing['label']}" if thing["colour"] else str(thing["label"])


def _place(thing: dict[str, Any]) -> str:
    return f"{_where(thing)} at {_metres(thing)} m".strip()


def _where(thing: dict[str, Any]) -> str:
    return f"{thing['relation']} the {thing['on']}" if thing["on"] else ""


def _metres(thing: dict[str, Any]) -> str:
    return " ".join(f"{value:.2f}" for value in thing["centre_m"])


def _row(thing: dict[str, Any]) -> tuple[str, ...]:
    where = f"{_where(thing)} ({thing['on_id']})" if thing["on"] else ""
    pixels = str(thing["pixels"]) if thing["pixels"] else ""
    return str(thing["id"]), _called(thing), where, _metres(thing), pixels
