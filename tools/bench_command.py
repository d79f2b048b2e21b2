"""``sceneq bench``: how fast, beside what everybody has."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.progress import Quiet, progress

if TYPE_CHECKING:
    from sceneq_tools.bench.measurement import Measurement, Options


def run(
    stage: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="STAGE",
            help="Default: codec, bus, render, stages, stream, laps, query, scale; or link.",
        ),
    ] = None,
    source: Annotated[
        Path | None,
        typer.Option(help="Folder of frames for stages, stream, laps and query; default: sample."),
    ] = None,
    graph: Annotated[
        Path | None, typer.Option(help="Default: ./graph.yaml, else the one in the package.")
    ] = None,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the measurements.")
    ] = None,
    baseline: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Compare with what --json wrote before.")
    ] = None,
    png: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Draw the ratios, and what grows with the recording."),
    ] = None,
    seconds: Annotated[
        float, typer.Option(min=0.01, help="Time for each sampling.", show_default=True)
    ] = 1.0,
    frames: Annotated[int | None, typer.Option(min=1, help="Look at so many frames only.")] = None,
    quiet: Quiet = False,
) -> None:
    """Measure codec, bus, rendering, a keyframe's stages, the stream, laps, queries and scale."""
    from sceneq_tools.bench.measurement import Options
    from sceneq_tools.bench.report import COLUMNS, as_json, read_baseline, rows
    from sceneq_tools.json_file import write_json
    from sceneq_tools.table import print_table

    then = None if baseline is None else read_baseline(baseline)
    source = source or sample()
    options = Options(source, graph, seconds, frames, quiet)
    results = measure(_chosen(stage or [], source), options)
    columns = COLUMNS if then is None else (*COLUMNS, "against baseline")
    print_table(columns, rows(results, then))
    if json_file is not None:
        write_json(as_json(results), json_file)
    if png is not None:
        from sceneq_tools.bench.chart import chart
        from sceneq_tools.scene_picture import write_png

        write_png(chart(results), png)


def measure(names: list[str], options: "Options") -> "dict[str, list[Measurement]]":
    """Run the benches one after the other: two at once would disturb each other."""
    from sceneq_tools.bench.registry import load
    from sceneq_tools.errors import UserError

    results = {}
    with progress("bench", len(names), "stages", options.quiet) as advance:
        for name in names:
            try:
                results[name] = list(load(name)(options))
            except ConnectionError as error:
                raise UserError(f"{name}: {error}") from error
            advance()
    return results


def sample() -> Path | None:
    """Return the recording that comes with Scene-Q, where there is one."""
    from importlib.resources import files

    folder = Path(str(files("sceneq_tools"))) / "sample"
    return folder if folder.is_dir() else None


def _chosen(names: list[str], source: Path | None) -> list[str]:
    """Return the benches to run: all that can, unless some are named."""
    from sceneq_tools.bench.registry import BENCHES, NEED_SOURCE, ON_REQUEST
    from sceneq_tools.errors import UserError

    if unknown := [name for name in names if name not in BENCHES]:
        raise UserError(f"no stage named {unknown[0]!r} (there are: {', '.join(BENCHES)})", 2)
    usual = [name for name in BENCHES if name not in ON_REQUEST]
    if names or source is not None:
        return names or usual
    left_out = ", ".join(sorted(NEED_SOURCE))
    typer.echo(f"left out without a recording: {left_out} (say which with --source)", err=True)
    return [name for name in usual if name not in NEED_SOURCE]
