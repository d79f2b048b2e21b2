"""``sceneq up``: run this machine's part of a graph until Ctrl-C."""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from sceneq_tools.graph import Graph, Override
    from sceneq_tools.graph_plan import Plan

GraphFile = Annotated[
    Path | None,
    typer.Argument(
        metavar="GRAPH.YAML", help="Default: ./graph.yaml, else the one in the package."
    ),
]
Source = Annotated[
    Path | None,
    typer.Option(help="Recording to play: a folder or file of a known kind (docs/sources.md)."),
]
Scene = Annotated[str | None, typer.Option(help="Default: the name of the source folder.")]
Rate = Annotated[
    float | None, typer.Option(help="Source frames a second; 0 = as fast as the graph takes them.")
]
Step = Annotated[int | None, typer.Option(help="Read every Nth frame.")]
Loop = Annotated[bool, typer.Option("--loop", help="Start again at the end of the source.")]
NoPoses = Annotated[
    bool, typer.Option("--no-poses", help="Ignore given poses, use odometry instead.")
]
Sim = Annotated[
    str | None,
    typer.Option(
        metavar="ROOM", help="Simulate instead: kitchen, living_room, office, bedroom or mixed."
    ),
]
Seed = Annotated[int | None, typer.Option(min=0, help="Which of these rooms; needs --sim.")]
Camera = Annotated[
    str | None, typer.Option(metavar="MAKER", help="Live: realsense, oak, orbbec or record3d.")
]
CAMERAS = ("realsense", "oak", "orbbec", "record3d")
Viewer = Annotated[
    str | None,
    typer.Option(metavar="serve|FILE.rrd|URL", help="Watch it in Rerun, as sceneq viewer does."),
]
Segmenter = Annotated[
    str | None, typer.Option(help="Kind: rgbd, or files = masks beside the frames, ...")
]
Record = Annotated[
    Path | None,
    typer.Option(metavar="OUT.mcap", help="Record all of it, as sceneq record does."),
]
Store = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Keep the map in DIR/SCENE and go on with it.")
]
SIM_RATE_HZ = CAMERA_RATE_HZ = 30.0


def run(
    graph: GraphFile = None,
    source: Source = None,
    scene: Scene = None,
    rate: Rate = None,
    step: Step = None,
    loop: Loop = False,
    no_poses: NoPoses = False,
    segmenter: Segmenter = None,
    sim: Sim = None,
    seed: Seed = None,
    camera: Camera = None,
    only: Annotated[
        list[str] | None, typer.Option(metavar="NODE,...", help="Only these; may be repeated.")
    ] = None,
    without: Annotated[
        list[str] | None, typer.Option(metavar="NODE,...", help="Not these; may be repeated.")
    ] = None,
    machine: Annotated[str, typer.Option(help="Run what is deployed to this machine.")] = "local",
    port: Annotated[
        int | None, typer.Option(min=1, max=65535, help="TCP port of the router.")
    ] = None,
    connect: Annotated[
        list[str] | None, typer.Option(help="Router of another machine: tcp/HOST:7447.")
    ] = None,
    viewer: Viewer = None,
    record: Record = None,
    store: Store = None,
    secure: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Credentials of 'sceneq secure init': TLS only."),
    ] = None,
    log_dir: Annotated[
        Path | None, typer.Option(help="Default: ~/.local/state/sceneq/SCENE.")
    ] = None,
) -> None:
    """Run the graph: a router and one process per node; Ctrl-C stops everything."""
    from sceneq_tools.graph import default_path, load
    from sceneq_tools.graph_check import check_nodes
    from sceneq_tools.graph_plan import need_free_port, plan
    from sceneq_tools.record_option import with_recorder
    from sceneq_tools.viewer_option import with_viewer

    is_sim = sim is not None or seed is not None
    if is_sim:
        _need_sim_alone(sim, source, step, loop)
    overrides = sim_overrides(str(sim), seed, scene, rate) if is_sim else []
    overrides += source_overrides(source, scene, rate, step, loop, no_poses, segmenter)
    overrides += camera_overrides(camera, scene, rate)
    overrides += _graph_overrides(connect, store, secure)
    loaded, document = load(graph or default_path(), overrides)
    check_nodes(loaded, document)
    names = _chosen_names(loaded, machine, only or (), without or ())
    local = with_viewer(plan(loaded, document, machine, names, port, connect or ()), viewer)
    local = with_recorder(local, record)
    for endpoint in local.router.listen:
        need_free_port(endpoint)
    raise typer.Exit(_launch(local, log_dir))


def source_overrides(
    source: Path | None,
    scene: str | None,
    rate: float | None,
    step: int | None,
    loop: bool,
    no_poses: bool,
    segmenter: str | None,
) -> "list[Override]":
    """Return what the options about the source put over the graph file."""
    from sceneq_tools.graph import Override
    from sceneq_tools.live_source import is_live, live_overrides, need_live_options

    if is_live(source):
        need_live_options(step, loop)
        live = live_overrides(source, scene, rate, no_poses)
        chosen = _segmenter(segmenter, None)
        masks = Override("segmentation", ("segmenter",), chosen, "--segmenter")
        return live if chosen is None else [*live, masks]

    given = [
        ("", ("scene",), scene, "--scene"),
        ("ingest", ("source", "kind"), source and source_kind(source), "--source"),
        ("ingest", ("source", "path"), source and str(source.resolve()), "--source"),
        ("ingest", ("source", "step"), step, "--step"),
        ("ingest", ("source", "loop"), loop or None, "--loop"),
        ("ingest", ("source", "use_poses"), False if no_poses else None, "--no-poses"),
        ("ingest", ("rate_hz",), rate, "--rate"),
        ("ingest", ("keyframes",), source and keyframes_of(source), "--source"),
        ("segmentation", ("segmenter",), _segmenter(segmenter, source), "--segmenter"),
    ]
    return [Override(*override) for override in given if override[2] is not None]


def source_kind(path: Path) -> str:
    """Return the kind of recording that ``path`` is; ``UserError`` when it is none."""
    from sceneq_nodes._source_kinds import need_kind
    from sceneq_tools.errors import UserError

    try:
        return need_kind(path)
    except ValueError as error:
        raise UserError(str(error), 2) from error


def keyframes_of(path: Path) -> dict[str, object] | None:
    """Return the choice of keyframes that goes with a recording of keyframes: all of them."""
    return {"kind": "every", "every": 1} if source_kind(path) == "mcap" else None


def sim_overrides(
    room: str, seed: int | None = None, scene: str | None = None, rate: float | None = None
) -> "list[Override]":
    """Return what a live simulation puts over the graph file.

    ``room`` is one of the kinds of rooms; ``rate`` frames a second; the scene is called after
    the room.
    """
    from sceneq_tools.graph import Override

    rate_hz = rate or SIM_RATE_HZ
    source = {"kind": "sim", "room": room, "rate_hz": rate_hz}
    if seed is not None:
        source["seed"] = seed
    return [
        Override("", ("scene",), scene or room, "--sim"),
        Override("ingest", ("source",), source, "--sim"),
        Override("ingest", ("rate_hz",), rate_hz, "--rate"),
    ]


def camera_overrides(
    maker: str | None, scene: str | None = None, rate: float | None = None
) -> "list[Override]":
    """Return what a camera on this machine puts over the graph file; every image is looked at."""
    from sceneq_tools.errors import UserError
    from sceneq_tools.graph import Override

    if maker is None:
        return []
    if maker not in CAMERAS:
        raise UserError(f"--camera {maker}: expected one of {', '.join(CAMERAS)}", 2)
    return [
        Override("", ("scene",), scene or maker, "--camera"),
        Override("ingest", ("source",), {"kind": maker}, "--camera"),
        Override("ingest", ("rate_hz",), rate or CAMERA_RATE_HZ, "--rate"),
    ]


def _graph_overrides(
    connect: list[str] | None, store: Path | None, secure: Path | None
) -> "list[Override]":
    """Return what concerns all of the graph."""
    from sceneq_tools.graph import Override

    given = [
        (("router", "connect"), connect or None, "--connect"),
        (("store",), store and str(store), "--store"),
        (("secure",), secure and str(secure), "--secure"),
    ]
    return [Override("", path, value, option) for path, value, option in given if value is not None]


def _chosen_names(
    graph: "Graph", machine: str, only: Iterable[str], without: Iterable[str]
) -> list[str]:
    """Return the ids of the nodes to run; none = all of the machine's."""
    from sceneq_nodes._params import did_you_mean
    from sceneq_tools.errors import UserError

    names, left_out = ([n for many in given for n in many.split(",")] for given in (only, without))
    known = {node.id for node in graph.nodes if node.deploy.machine == machine}
    for name in left_out:
        if name not in known:
            raise UserError(f"--without {name}: no such node here ({did_you_mean(name, known)})", 2)
    if not left_out:
        return names
    return [name for name in names or sorted(known) if name not in left_out]


def _need_sim_alone(sim: str | None, source: Path | None, step: int | None, loop: bool) -> None:
    """Refuse what says nothing about a simulation."""
    from sceneq_tools.errors import UserError

    if sim is None:
        raise UserError("--seed says which simulated room: say --sim ROOM too", 2)
    given = {"--source": source is not None, "--step": step is not None, "--loop": loop}
    if clash := [option for option, is_given in given.items() if is_given]:
        raise UserError(f"--sim and {', '.join(clash)}: a simulation is no recording", 2)


def _segmenter(kind: str | None, source: Path | None) -> dict[str, str] | None:
    """Masks from files lie beside the frames."""
    if kind is None:
        return None
    beside = {"path": str(source.resolve())} if kind == "files" and source else {}
    return {"kind": kind, **beside}


def _launch(local: "Plan", log_dir: Path | None) -> int:
    import signal
    import threading

    from sceneq_tools.console import Console
    from sceneq_tools.launcher import Launcher, default_logs

    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: stop.set())
    return Launcher(local, log_dir or default_logs(local.scene), Console()).run(stop)
