"""``sceneq import``: a recording of any kind into ours, a folder of frames or an MCAP file."""

from pathlib import Path
from typing import Annotated, Any

import typer

from sceneq_tools.progress import Quiet


def run(
    source: Annotated[Path, typer.Argument(metavar="SRC", help="Recording (docs/sources.md).")],
    out: Annotated[Path, typer.Argument(metavar="DST", help="New folder, or a file OUT.mcap.")],
    step: Annotated[int, typer.Option(min=1, help="Every Nth frame.")] = 1,
    quality: Annotated[
        int | None,
        typer.Option(min=1, max=100, help="Colour as JPEG of this quality; default: PNG, exact."),
    ] = None,
    no_poses: Annotated[
        bool, typer.Option("--no-poses", help="Leave given poses out; not for OUT.mcap.")
    ] = False,
    params: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Parameter of the source; repeatable."),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Convert a recording; bad frames are left out and counted."""
    from sceneq_nodes._backends import build
    from sceneq_nodes._params import ParamError
    from sceneq_tools.errors import UserError
    from sceneq_tools.importing import import_folder, import_mcap
    from sceneq_tools.playing import play
    from sceneq_tools.up_command import source_kind

    spec: dict[str, Any] = {"kind": source_kind(source), "path": str(source), "step": step}
    spec |= {"use_poses": not no_poses} | dict(map(_setting, params or ()))
    try:
        opened = build("source", spec)
        convert = import_mcap if out.suffix == ".mcap" else import_folder
        done = convert(opened, out, quality)
        play([done.stage], quiet)
    except (ParamError, ValueError) as error:
        raise UserError(str(error), 2) from error
    except OSError as error:
        raise UserError(f"{out}: {error.strerror}") from error
    typer.echo(f"{done.frames} frames in {out}")
    if done.skipped:
        typer.echo(f"{done.skipped} bad frames left out; the first: {done.first_reason}")
    if not done.frames:
        raise UserError("no frame could be used")


def _setting(text: str) -> tuple[str, Any]:
    import yaml

    from sceneq_tools.errors import UserError

    name, equals, value = text.partition("=")
    if not (name and equals):
        raise UserError(f"--set {text}: expected NAME=VALUE", 2)
    try:
        return name, yaml.safe_load(value)
    except yaml.YAMLError as error:
        raise UserError(f"--set {text}: {error}", 2) from error
