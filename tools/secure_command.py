"""``sceneq secure``: certificates for the machines and people of a site, and who may do what."""

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from sceneq_tools.security.authority import Authority
    from sceneq_tools.security.site import Site

app = typer.Typer(
    help="Make certificates, so that nobody joins the bus whom you did not let in.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Where the authority is.")]
Hosts = Annotated[
    list[str] | None,
    typer.Option("--host", help="Name or address at which routers are reached; may be repeated."),
]
Scenes = Annotated[
    list[str] | None,
    typer.Option("--scene", help="Scenes for which credentials of one scene are issued."),
]
Graphs = Annotated[
    list[Path] | None,
    typer.Option("--graph", help="Let the ROS 2 topics of this graph.yaml pass, and no others."),
]
Days = Annotated[int, typer.Option(min=1, help="How long certificates are valid.")]
VALID_DAYS = 365
LOCAL = ("localhost", "127.0.0.1", "::1")
AUTHORITY_FOLDER = "authority"


@app.command("init")
def init(
    folder: Folder,
    host: Hosts = None,
    scene: Scenes = None,
    graph: Graphs = None,
    days: Days = VALID_DAYS,
) -> None:
    """Make an authority and credentials for a router, the nodes and an operator.

    Run again with more --scene, or another --graph, to write the router's access rules anew; what
    was issued stays.
    """
    from sceneq_tools.errors import UserError
    from sceneq_tools.security.authority import Authority
    from sceneq_tools.security.roles import OPERATOR, ROBOT, ROUTER, SERVER

    _need_scenes(scene or [])
    now = datetime.now(UTC)
    site = folder / AUTHORITY_FOLDER
    try:
        fresh = not (site / "ca.pem").exists()
        authority = Authority.create(site, now) if fresh else _authority(folder)
        for role in (ROUTER, ROBOT, SERVER, OPERATOR):
            if not (folder / role / "cert.pem").exists():
                hosts = (*LOCAL, *(host or ())) if role == ROUTER else ()
                authority.issue(folder / role, role, role, hosts, now, days)
        kept = _write_access(folder, scene or [], graph)
    except OSError as error:
        raise UserError(f"{error.filename or folder}: {error.strerror}") from error
    typer.echo(f"{folder}: {'made' if fresh else 'kept'}, access rules for {_said(kept)}")
    typer.echo(f"sceneq up --secure {folder}")
    typer.echo(f"SCENEQ_CREDENTIALS={folder / OPERATOR} sceneq status --connect tls/127.0.0.1:7447")


@app.command("issue")
def issue(
    folder: Folder,
    role: Annotated[str, typer.Argument(help="One of those of 'sceneq secure roles'.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder to write into.")],
    scene: Annotated[str | None, typer.Option(help="Only this scene.")] = None,
    name: Annotated[str, typer.Option(help="For whom, such as anna.")] = "",
    host: Hosts = None,
    days: Days = VALID_DAYS,
) -> None:
    """Issue credentials: a folder for the one who gets them."""
    from sceneq_tools.errors import UserError
    from sceneq_tools.security.access import subject
    from sceneq_tools.security.roles import ROS, ROUTER, grants

    try:
        site = _site(folder)
        if not grants(role, scene, site.ros) and role == ROS:
            raise ValueError(
                "ros: no topics are let through (sceneq secure init --graph graph.yaml)"
            )
        if scene is not None and scene not in site.scenes:
            raise ValueError(
                f"--scene {scene}: not known here (sceneq secure init --scene {scene})"
            )
        hosts = (*LOCAL, *(host or ())) if role == ROUTER else ()
        holder = name or subject(role, scene)
        now = datetime.now(UTC)
        _authority(folder).issue(out, subject(role, scene), holder, hosts, now, days)
        if role == ROUTER:
            _write_rules(out, site)
    except FileExistsError as error:
        raise UserError(f"{out}: there are credentials already", 2) from error
    except OSError as error:
        raise UserError(f"{error.filename or out}: {error.strerror}") from error
    except ValueError as error:
        raise UserError(str(error), 2) from error
    typer.echo(f"{out}: {subject(role, scene)}, for {holder}; use it with SCENEQ_CREDENTIALS={out}")


@app.command("roles")
def roles() -> None:
    """Say what every role may do."""
    from sceneq_tools.security.roles import ROLES
    from sceneq_tools.table import print_table

    print_table(("role", "may"), ROLES.items())


def _authority(folder: Path) -> "Authority":
    from sceneq_tools.errors import UserError
    from sceneq_tools.security.authority import Authority

    try:
        return Authority.open(folder / AUTHORITY_FOLDER)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        hint = f"make one: sceneq secure init {folder}"
        raise UserError(
            f"{folder / AUTHORITY_FOLDER}: no authority: {reason} ({hint})", 2
        ) from error


def _need_scenes(scenes: list[str]) -> None:
    from sceneq_schemas.topics import ID
    from sceneq_tools.errors import UserError

    for scene in scenes:
        if not ID.fullmatch(scene):
            raise UserError(f"--scene {scene!r}: must match {ID.pattern}", 2)


def _site(folder: Path) -> "Site":
    from sceneq_tools.security.site import read_site

    return read_site(folder / AUTHORITY_FOLDER)


def _write_access(folder: Path, scenes: list[str], graphs: list[Path] | None) -> "Site":
    """Write the rules for what is known and new; ``graphs`` say all that passes of ROS."""
    from sceneq_nodes.ros.passage import RosKeys
    from sceneq_tools.security.ros_keys import keys_in_graph
    from sceneq_tools.security.site import Site, write_site

    known = _site(folder)
    ros = known.ros
    if graphs is not None:
        ros = RosKeys()
        for graph in graphs:
            ros |= keys_in_graph(graph)
    site = Site(tuple(sorted({*known.scenes, *scenes})), ros)
    write_site(folder / AUTHORITY_FOLDER, site)
    _write_rules(folder / "router", site)
    return site


def _said(site: "Site") -> str:
    scenes = ", ".join(site.scenes) or "all scenes together"
    keys = len(site.ros.read) + len(site.ros.written)
    return scenes + (f", {keys} keys of ROS" if keys else "")


def _write_rules(router: Path, site: "Site") -> None:
    from sceneq_nodes._credentials import ACCESS
    from sceneq_tools.security.access import access_rules

    (router / ACCESS).write_text(json.dumps(access_rules(site), indent=1) + "\n")
