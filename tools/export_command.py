"""``sceneq export``: write what a running graph knows about a scene."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint

if TYPE_CHECKING:
    from sceneq_nodes._bus import Reply
    from sceneq_nodes._client import Client
    from sceneq_schemas.topics import Topic
    from sceneq_tools.collect import Get
    from sceneq_tools.export.scene import ExportedScene
    from sceneq_tools.scene_files import SceneFiles

TIMEOUT_S = 60.0
MOST_NAMED = 12
Rrd = Annotated[bool, typer.Option("--rrd", help="Also write scene.rrd for the Rerun viewer.")]


def run(
    out: Annotated[Path, typer.Argument(help="Folder to write into.")],
    formats: Annotated[
        list[str] | None,
        typer.Option(
            "--as",
            metavar="FORMAT",
            help="native (default), ply, glb, graph, csv, scannet, coco, costmap or rrd; "
            "may be repeated.",
        ),
    ] = None,
    source: Annotated[
        Path | None,
        typer.Option("--from", help="Folder written by sceneq map. Default: the running graph."),
    ] = None,
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Write what a scene holds in the form that another program reads (docs/exports.md)."""
    from sceneq_tools import scenes
    from sceneq_tools.export.formats import write
    from sceneq_tools.export.scene import from_folder

    wanted = formats or ["native"]
    if source is not None:
        written = write(from_folder(source), wanted, out)
    else:
        with scenes.connect(connect) as client:
            name = scenes.need_scene(client, scene)
            written = write(_running(client, name), wanted, out)
    for path in written[:MOST_NAMED]:
        typer.echo(path)
    if len(written) > MOST_NAMED:
        typer.echo(f"and {len(written) - MOST_NAMED} more")


def _running(client: "Client", scene: str) -> "ExportedScene":
    from sceneq_tools.collect import collect
    from sceneq_tools.export.scene import from_files

    def picture(key: str) -> bytes | None:
        replies, _ = client.get(key, timeout_s=TIMEOUT_S)
        return replies[-1][1].payload if replies else None

    return from_files(collect(getter(client, scene), scene), picture)


def write_all(files: "SceneFiles", out: Path, rrd: bool) -> None:
    """Write the files of a scene and say in one line what they hold."""
    from sceneq_tools.scene_files import describe

    summary = files.write(out)
    if rrd:
        from sceneq_tools.rerun_file import write_rerun

        write_rerun(files, out / "scene.rrd")
    typer.echo(describe(summary, out))


def getter(client: "Client", scene: str) -> "Get":
    """Return what ``collect`` asks with, over the network."""
    from sceneq_tools.errors import UserError

    def get(topic: "Topic", parameters: Mapping[str, Any], **ids: str) -> "Reply | None":
        said = ";".join(f"{name}={value}" for name, value in parameters.items())
        selector = topic.key(scene=scene, **ids) + (f"?{said}" if said else "")
        replies, errors = client.get(selector, timeout_s=TIMEOUT_S)
        if errors:
            raise UserError(f"{selector}: {errors[0]}")
        return replies[-1][1] if replies else None

    return get
