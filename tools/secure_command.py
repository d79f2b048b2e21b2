"""``sceneq secure``: certificates for the machines and people of a site, and who may do what."""

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from sceneq_tools.security.authority import Authority

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
Days = Annotated[int, typer.Option(min=1, help="How long certificates are valid.")]
VALID_DAYS = 365
LOCAL = ("localhost", "127.0.0.1", "::1")
AUTHORITY_FOLDER, SITE_FILE = "authority", "site.json"


@app.command("init")
def init(folder: Folder, host: Hosts = None, scene: Scenes = None, days: Days = VALID_DAYS) -> None:
    """Make an authority and credentials for a router, the nodes and an operator.

    Run again with more --scene to write the router's access rules anew; what was issued stays.
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
        scenes = _write_access(folder, scene or [])
    except OSError as error:
        raise UserError(f"{error.filename or folder}: {error.strerror}") from error
    typer.echo(f"{folder}: {'made' if fresh else 'kept'}, access rules for {scenes}")
    typer.echo(f"sceneq up --secure {folder}")
    typer.echo(f"SCENEQ_CREDENTIALS={folder / OPERATOR} sceneq status --connect tls/127.0.0.1:7447")


@app.command("issue")
def issue(
    folder: Folder,
    role: Annotated[str, typer.Argument(help="client, viewer, operator, robot, server, router.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder to write into.")],
    scene: Annotated[str | None, typer.Option(help="Only this scene.")] = None,
    name: Annotated[str, typer.Option(help="For whom, such as anna.")] = "",
    host: Hosts = None,
    days: Days = VALID_DAYS,
) -> None:
    """Issue credentials: a folder for the one who gets them."""
    from sceneq_tools.errors import UserError
    from sceneq_tools.security.access import subject
    from sceneq_tools.security.roles import ROUTER, grants

    try:
        grants(role, scene)
        if scene is not None and scene not in _site(folder):
            raise ValueError(
                f"--scene {scene}: not known here (sceneq secure init --scene {scene})"
            )
        hosts = (*LOCAL, *(host or ())) if role == ROUTER else ()
        holder = name or subject(role, scene)
        now = datetime.now(UTC)
        _authority(folder).issue(out, subject(role, scene), holder, hosts, now, days)
        if role == ROUTER:
            _write_rules(out, _site(folder))
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


def _site(folder: Path) -> list[str]:
    path = folder / AUTHORITY_FOLDER / SITE_FILE
    return list(json.loads(path.read_text())["scenes"]) if path.is_file() else []


def _write_access(folder: Path, scenes: list[str]) -> str:
    """Write the rules for what is known and new; return the scenes, for people."""
    known = sorted({*_site(folder), *scenes})
    (folder / AUTHORITY_FOLDER / SITE_FILE).write_text(json.dumps({"scenes": known}) + "\n")
    _write_rules(folder / "router", known)
    return ", ".join(known) or "all scenes together"


def _write_rules(router: Path, scenes: list[str]) -> None:
    from sceneq_nodes._credentials import ACCESS
    from sceneq_tools.security.access import access_rules

    (router / ACCESS).write_text(json.dumps(access_rules(scenes), indent=1) + "\n")
