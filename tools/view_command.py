"""``sceneq view``: a picture of a scene, without a display."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, REASON_TIMEOUT_S, Endpoint

if TYPE_CHECKING:
    from sceneq_core.picture.scene import Cloud, Mark
    from sceneq_nodes._client import Client

SIZE = "1600x1000"
SIZE_FORM = re.compile(r"(\d{3,5})x(\d{3,5})")


def run(
    png: Annotated[Path, typer.Option("--png", metavar="FILE", help="Picture to write.")],
    source: Annotated[
        Path | None,
        typer.Argument(help="Folder written by sceneq map or export. Default: the running graph."),
    ] = None,
    question: Annotated[
        str | None, typer.Option(metavar="TEXT", help="Ask the running graph, show its answer.")
    ] = None,
    highlight: Annotated[
        list[int] | None, typer.Option(metavar="ID", help="Show this instance; may be repeated.")
    ] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="Pixels of the picture.")] = SIZE,
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Draw a scene from above and from two corners, with names; an answer stands out."""
    from sceneq_tools.errors import UserError
    from sceneq_tools.scene_files import read_scene
    from sceneq_tools.scene_picture import scene_picture, write_png

    pixels = parsed_size(size)
    if source is not None and question is not None:
        raise UserError("a folder cannot be asked (show an instance of it: --highlight ID)", 2)
    if source is not None:
        cloud, document = read_scene(source)
        answer = None
    else:
        cloud, document, answer = _from_graph(connect, scene, question)
    marks = [*marks_of_ids(document, highlight or ()), *marks_of_answer(answer)]
    image = scene_picture(cloud, document, marks, asked(question, answer), pixels)
    write_png(image, png)
    typer.echo(f"picture: {png}")


def parsed_size(text: str) -> tuple[int, int]:
    """Return width and height.

    Raises:
        UserError: the text is not of the form 1600x1000.
    """
    from sceneq_tools.errors import UserError

    found = SIZE_FORM.fullmatch(text)
    if found is None:
        raise UserError(f"--size {text!r}: expected WIDTHxHEIGHT in pixels, such as {SIZE}", 2)
    return int(found[1]), int(found[2])


def marks_of_ids(document: Mapping[str, Any], ids: Sequence[int]) -> "list[Mark]":
    """Return a mark for each instance id.

    Raises:
        UserError: the scene has no such instance.
    """
    from sceneq_tools.errors import UserError
    from sceneq_tools.scene_picture import mark_of

    records = {record["id"]: record for record in document["instances"]}
    if unknown := [number for number in ids if number not in records]:
        raise UserError(f"--highlight {unknown[0]}: the scene has no such instance", 2)
    return [mark_of(records[number], f"p {records[number]['p']:.2f}") for number in ids]


def marks_of_answer(answer: Mapping[str, Any] | None) -> "list[Mark]":
    """Return the mark of the best instance of an answer, with its p for this question."""
    from sceneq_tools.scene_picture import mark_of

    if answer is None or answer.get("status") == "not_found" or not answer.get("instances"):
        return []
    best = answer["instances"][0]
    return [mark_of(best, f"p {best['p']:.2f} · {answer.get('route', '')} route")]


def asked(question: str | None, answer: Mapping[str, Any] | None) -> str:
    """Return the question and how it was answered, as it stands over the picture."""
    if question is None or answer is None:
        return ""
    return f"“{question}”: {str(answer.get('status', '')).replace('_', ' ')}"


def _from_graph(
    endpoint: str, scene: str | None, question: str | None
) -> "tuple[Cloud, dict[str, Any], dict[str, Any] | None]":
    from sceneq_tools import scenes
    from sceneq_tools.collect import collect
    from sceneq_tools.export_command import getter

    with scenes.connect(endpoint) as client:
        name = scenes.need_scene(client, scene)
        answer = None if question is None else _ask(client, name, question)
        files = collect(getter(client, name), name)
    cloud = files.cloud()
    return cloud, files.document(cloud), answer


def _ask(client: "Client", scene: str, question: str) -> dict[str, Any]:
    from sceneq_schemas.topics import QUERY_ASK
    from sceneq_tools import scenes

    request = {"q": question, "k": 3}
    return scenes.ask(client, QUERY_ASK, scene, request, REASON_TIMEOUT_S).body
