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
    from sceneq_tools.scene_files import SceneFiles

TIMEOUT_S = 60.0
Rrd = Annotated[bool, typer.Option("--rrd", help="Also write scene.rrd for the Rerun viewer.")]


def run(
    out: Annotated[Path, typer.Argument(help="Folder to write into.")],
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    rrd: Rrd = False,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Write instances.npz, instances.json, cloud.ply and instances.png of a running graph."""
    from sceneq_tools import scenes
    from sceneq_tools.collect import collect

    with scenes.connect(connect) as client:
        name = scenes.need_scene(client, scene)
        files = collect(getter(client, name), name)
    write_all(files, out, rrd)


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
