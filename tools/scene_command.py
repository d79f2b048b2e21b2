"""``sceneq scene``: the maps that are kept on disk."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from sceneq_core.places.visit import Visit
    from sceneq_nodes._scene_folder import SceneFacts, SceneFolder

app = typer.Typer(no_args_is_help=True, help="List, check and tidy the maps kept on disk.")

Store = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Default: the store of ./graph.yaml.")
]
Scene = Annotated[str, typer.Argument(help="Name of the scene.")]
Yes = Annotated[bool, typer.Option("--yes", help="Do not ask.")]
AsJson = Annotated[bool, typer.Option("--json", help="As JSON, for programs.")]


@app.command("list")
def list_scenes(store: Store = None, as_json: AsJson = False) -> None:
    """List the scenes: what is known of each and how much room it takes."""
    import json
    from dataclasses import asdict

    from sceneq_tools.table import print_table

    facts = [_facts(folder) for folder in _find(store)]
    if as_json:
        typer.echo(json.dumps([asdict(one) for one in facts], indent=2))
        return
    columns = ("scene", "in the map", "keyframes", "described", "MB", "")
    print_table(columns, [_row(one) for one in facts])


@app.command()
def info(scene: Scene, store: Store = None, as_json: AsJson = False) -> None:
    """Tell what is kept of one scene."""
    import json
    from dataclasses import asdict

    from sceneq_nodes._held_files import Caller
    from sceneq_nodes._visit_json import visit_json

    folder = _one(store, scene)
    facts = _facts(folder)
    with _told():
        held = {waiting.caller: waiting.keyframes for waiting in folder.waiting()}
        visits = [(visit, held.get(Caller.of(visit), 0)) for visit in folder.visits()]
    if as_json:
        told = [visit_json(visit) | {"held": count} for visit, count in visits]
        typer.echo(json.dumps(asdict(facts) | {"visits": told}, indent=2))
        return
    for line in (*_lines(facts), *(_visit_line(visit, count) for visit, count in visits)):
        typer.echo(line)


@app.command()
def verify(scene: Scene, store: Store = None) -> None:
    """Read every file of a scene; exit code 1 if one cannot be used."""
    is_bad = False
    for verdict in _one(store, scene).verify():
        is_bad |= bool(verdict.problem)
        typer.echo(f"{verdict.file}: {verdict.problem or 'ok'}")
    raise typer.Exit(int(is_bad))


@app.command()
def compact(scene: Scene, store: Store = None) -> None:
    """Keep the newest map and what came after, not how it came about; drop what was set aside."""
    folder = _one(store, scene)
    before = _facts(folder).size_bytes
    with _told():
        folder.compact()
    after = _facts(folder).size_bytes
    typer.echo(f"{scene}: {before / 1e6:.1f} MB -> {after / 1e6:.1f} MB")


@app.command()
def delete(scene: Scene, store: Store = None, yes: Yes = False) -> None:
    """Delete a scene with all its files."""
    folder = _one(store, scene)
    if not yes:
        typer.confirm(f"delete {folder.path} with all that is in it?", abort=True)
    with _told():
        folder.delete()
    typer.echo(f"{scene}: deleted")


@app.command()
def drop(
    scene: Scene,
    visit: Annotated[int, typer.Argument(help="Its number in `sceneq scene info`.")],
    store: Store = None,
    yes: Yes = False,
) -> None:
    """Delete what a visit holds that is not placed in the map."""
    from sceneq_nodes._held_files import Caller
    from sceneq_tools.errors import UserError

    folder = _one(store, scene)
    with _told():
        callers = {one.number: Caller.of(one) for one in folder.visits()}
        held = {waiting.caller: waiting for waiting in folder.waiting()}
    waiting = held.get(callers[visit]) if visit in callers else None
    if waiting is None:
        raise UserError(f"visit {visit} of {scene} holds nothing (sceneq scene info {scene})", 2)
    if not yes:
        typer.confirm(f"delete {waiting.keyframes} keyframes of visit {visit}?", abort=True)
    with _told():
        folder.drop(waiting)
    typer.echo(f"{scene}: {waiting.keyframes} keyframes of visit {visit} deleted")


@app.command()
def merge(
    scene: Scene,
    other: Annotated[str, typer.Argument(help="The scene that becomes part of it.")],
    out: Annotated[
        str | None, typer.Option(metavar="NAME", help="Make a new scene; default: change SCENE.")
    ] = None,
    store: Store = None,
) -> None:
    """Make OTHER part of SCENE: aligned where they overlap, one set of instances."""
    import re

    from sceneq_schemas.topics import ID
    from sceneq_tools.errors import UserError
    from sceneq_tools.scene_merge import merge as merged_into

    one, two = _one(store, scene), _one(store, other)
    if out is not None and not re.fullmatch(ID, out):
        raise UserError(f"--out {out!r}: must match {ID.pattern}", 2)
    into = one.path if out is None else one.path.parent / out
    if scene == other or (out is not None and into.exists()):
        raise UserError(f"{out or other}: is there already" if out else "one scene twice", 2)
    with _told():
        done = merged_into(one, two, into, _node_params())
    found, (before, after) = done.found, done.instances
    typer.echo(
        f"{other} lies in {scene}: {found.keyframes} of its places recognised at {found.places}, "
        f"{found.features} features, trust {found.trust:.2f}, spread {100 * found.spread_m:.1f} cm"
    )
    typer.echo(
        f"{into.name}: {done.keyframes} keyframes of {other} taken in as visit "
        f"{', '.join(map(str, done.visits))}, {before} -> {after} instances"
    )
    if done.waiting:
        typer.echo(f"{into.name}: {done.waiting} keyframes that {other} did not place wait here")


def _node_params() -> "dict[str, dict[str, Any]]":
    """Return the parameters of mapping and views in ./graph.yaml, or those by default."""
    from sceneq_tools.graph import default_path, load

    graph, _ = load(default_path())
    return {node.node_kind: node.params for node in graph.nodes}


def _find(store: Path | None) -> "list[SceneFolder]":
    from sceneq_nodes._scene_folder import find

    with _told():
        return find(store or _default_store())


def _one(store: Path | None, scene: str) -> "SceneFolder":
    from sceneq_nodes._params import did_you_mean
    from sceneq_tools.errors import UserError

    found = {folder.path.name: folder for folder in _find(store)}
    if scene not in found:
        raise UserError(f"no scene {scene} ({did_you_mean(scene, set(found))})", 2)
    return found[scene]


def _facts(folder: "SceneFolder") -> "SceneFacts":
    with _told():
        return folder.facts()


def _default_store() -> Path:
    from sceneq_tools.errors import UserError
    from sceneq_tools.graph import default_path, load

    graph, _ = load(default_path())
    if graph.store is None:
        raise UserError("say which folder: --store DIR, or store: DIR in graph.yaml", 2)
    return Path(graph.store).expanduser()


@contextmanager
def _told() -> Iterator[None]:
    """Turn what is wrong with the files into a line for the user."""
    from sceneq_nodes._set_aside import StoreError
    from sceneq_tools.errors import UserError

    try:
        yield
    except (StoreError, OSError) as error:
        raise UserError(str(error)) from error


def _row(facts: "SceneFacts") -> tuple[str, ...]:
    return (
        facts.name,
        str(facts.position),
        str(facts.keyframes),
        ", ".join(f"{count} by {model}" for model, count in facts.described.items()),
        f"{facts.size_bytes / 1e6:.1f}",
        ", ".join(filter(None, (_waiting(facts), "in use" if facts.is_in_use else ""))),
    )


def _waiting(facts: "SceneFacts") -> str:
    from sceneq_nodes._held_files import waiting_text

    return waiting_text(facts.waiting_visits, facts.waiting_keyframes)


def _lines(facts: "SceneFacts") -> list[str]:
    kept = f"entries from {facts.first} on" if facts.first else "no entries"
    checkpoints = ", ".join(map(str, facts.checkpoints)) or "none"
    return [
        f"{facts.name}: {facts.position} entries made the map, {facts.size_bytes / 1e6:.1f} MB"
        + (", in use" if facts.is_in_use else ""),
        f"journal: {kept}; checkpoints at {checkpoints}",
        f"views: {facts.keyframes} keyframes",
        *(f"descriptors of {model}: {count}" for model, count in facts.described.items()),
        *([_waiting(facts)] if facts.waiting_visits else []),
        *(f"set aside: {name}" for name in facts.set_aside),
    ]


def _visit_line(visit: "Visit", held: int) -> str:
    came = f"visit {visit.number}: {visit.robot}"
    origin = f" in {visit.origin}" if visit.origin else ""
    known = visit.evidence if visit.T_world_odom is not None else "where it started is not known"
    return f"{came}{origin}: {known}" + (f"; {held} keyframes wait" if held else "")
