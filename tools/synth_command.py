"""``sceneq synth``: a recording of a furnished room with exact truth."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.errors import UserError

if TYPE_CHECKING:
    from sceneq_tools.synth import Plan, SynthParams

DEFAULT_FRAMES = 200
DEFAULT_CHANGES = 4


def run(
    out: Annotated[Path, typer.Argument(help="Folder to write; appears when all is done.")],
    seed: Annotated[int, typer.Option(min=0, help="Of everything: same seed, same bytes.")] = 0,
    frames: Annotated[
        int | None,
        typer.Option(min=1, help="How many frames.  [default: 200; 60 in each room of a suite]"),
    ] = None,
    room: Annotated[
        str, typer.Option(help="kitchen, living_room, office, bedroom or mixed.")
    ] = "mixed",
    changes: Annotated[
        bool, typer.Option("--changes", help="Things move, come and go on the way.")
    ] = False,
    rate: Annotated[float, typer.Option(help="Frames a second.")] = 10.0,
    pace: Annotated[float, typer.Option(help="Of the camera; 1 = a brisk walk.")] = 1.0,
    size: Annotated[str, typer.Option(help="Of the images, WIDTHxHEIGHT.")] = "640x480",
    clean: Annotated[bool, typer.Option("--clean", help="Without sensor noise.")] = False,
    quality: Annotated[int, typer.Option(min=1, max=100, help="Of the colour JPEGs.")] = 92,
    suite: Annotated[
        bool,
        typer.Option(
            "--suite",
            help="The benchmark of eight rooms; takes --rounds, --frames, --force, --quiet.",
        ),
    ] = False,
    rounds: Annotated[
        int, typer.Option(min=1, help="With --suite: nine rooms more for each further one.")
    ] = 1,
    force: Annotated[
        bool, typer.Option("--force", help="Write into a folder that holds other files too.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing but errors.")] = False,
) -> None:
    """Record a walk through a furnished room that does not exist, with exact truth."""
    from sceneq_tools.synth import SynthParams

    if suite:
        own = {"--seed": seed, "--changes": changes, "--clean": clean, "--room": room != "mixed"}
        camera = {"--rate": rate != 10.0, "--pace": pace != 1.0, "--size": size != "640x480"}
        _need_none(own | camera | {"--quality": quality != 92})
        _synth_suite(out, frames, rounds, force, quiet)
        return
    _need_one_round(rounds)
    try:
        params = SynthParams(
            seed=seed,
            kind=room,
            frames=frames or DEFAULT_FRAMES,
            rate_hz=rate,
            size=_size(size),
            pace=pace,
            changes=DEFAULT_CHANGES if changes else 0,
            clean=clean,
            jpeg_quality=quality,
        )
        summary = _synth(params, out, force, quiet)
    except (ValueError, OSError) as error:
        raise UserError(str(error)) from error
    if not quiet:
        typer.echo(summary)


def _synth(params: "SynthParams", out: Path, force: bool, quiet: bool) -> str:
    from sceneq_tools.progress import progress
    from sceneq_tools.room.light.renderer import Renderer
    from sceneq_tools.room.models.libraries import open_library
    from sceneq_tools.room.truth.recording_files import Output
    from sceneq_tools.synth import plan, record, write_truth

    with Output(out, force) as folder:
        with progress("furnishing and lighting", None, quiet=quiet):
            planned = plan(params, open_library())
            renderer = Renderer(planned.periods[0].room)
        with progress("rendering", params.frames, "frames", quiet) as advance:
            truth = record(planned, renderer, folder, advance)
        with progress("asking", None, quiet=quiet):
            queries = write_truth(planned, truth, folder, command_line(planned, out.name))
    return f"{params.frames} frames, {len(queries['queries'])} questions -> {out}"


def _need_none(given: "dict[str, int | bool]") -> None:
    """Refuse what the rooms of a suite decide themselves."""
    if clash := [option for option, is_given in given.items() if is_given]:
        raise UserError(f"--suite and {', '.join(clash)}: a suite says this of its rooms itself", 2)


def _need_one_round(rounds: int) -> None:
    """Refuse rounds of a room alone."""
    if rounds != 1:
        raise UserError(f"--rounds {rounds}: only with --suite, one room alone has no rounds", 2)


def _synth_suite(out: Path, frames: int | None, rounds: int, force: bool, quiet: bool) -> None:
    from sceneq_tools.room.models.libraries import open_library
    from sceneq_tools.suite import SuiteParams, make_suite, rooms_of

    def make(params: "SynthParams", folder: Path) -> str:
        return _synth(params, folder, force, quiet)

    try:
        params = SuiteParams(frames) if frames else SuiteParams()
        rooms = rooms_of(rounds)
        made = make_suite(out, params, open_library().name, make, quiet, rooms)
    except (ValueError, OSError) as error:
        raise UserError(str(error)) from error
    if not quiet:
        typer.echo(f"{made} rooms made, {len(rooms) - made} were there -> {out}")


def command_line(planned: "Plan", out: str) -> str:
    """Return the command that writes the same folder again."""
    params = planned.params
    width, height = params.size
    words = [
        f"sceneq synth {out} --seed {params.seed} --frames {params.frames} --room {params.kind}",
        f"--rate {params.rate_hz:g}" * (params.rate_hz != 10.0),
        f"--pace {params.pace:g}" * (params.pace != 1.0),
        f"--size {width}x{height}" * (params.size != (640, 480)),
        f"--quality {params.jpeg_quality}" * (params.jpeg_quality != 92),
        "--changes" * bool(params.changes),
        "--clean" * params.clean,
    ]
    return " ".join(word for word in words if word)


def _size(text: str) -> tuple[int, int]:
    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise ValueError(f"size: expected WIDTHxHEIGHT such as 640x480, got {text!r}")
    return int(width), int(height)
