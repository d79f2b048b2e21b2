"""``sceneq render``: a graph as files that systemd, Kubernetes or compose start."""

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from sceneq_tools.deploy.site import Site


class Target(StrEnum):
    """Who is to start the processes."""

    SYSTEMD = "systemd"
    KUBERNETES = "kubernetes"
    COMPOSE = "compose"


def run(
    target: Annotated[Target, typer.Option(help="Who is to start the processes.")],
    out: Annotated[Path, typer.Option(metavar="DIR", help="Gets a folder for each machine.")],
    graph: Annotated[
        Path | None, typer.Argument(metavar="GRAPH.YAML", help="Default: as for `sceneq up`.")
    ] = None,
    scene: Annotated[str | None, typer.Option(help="Default: as the graph says.")] = None,
    image: Annotated[
        str | None, typer.Option(help="Container image; default: sceneq:VERSION.")
    ] = None,
) -> None:
    """Write units or manifests, the routers' configuration and the nodes' environment.

    No file holds a secret: credentials are named by path, or as a Secret, and mounted read-only.
    """
    from sceneq_tools.deploy.site import sites
    from sceneq_tools.graph import Override, default_path, load
    from sceneq_tools.graph_check import check_nodes

    overrides = [Override("", ("scene",), scene, "--scene")] if scene else []
    loaded, document = load(graph or default_path(), overrides)
    check_nodes(loaded, document)
    for site in sites(loaded, document):
        folder = out / site.machine
        for name, text in rendered(target, site, image or default_image()).items():
            write(folder / name, text)
        typer.echo(f"{folder}: {target.value} for {1 + len(site.plan.nodes)} processes")


def rendered(target: Target, site: "Site", image: str) -> dict[str, str]:
    """Return file name -> content for one machine."""
    from sceneq_tools.deploy import compose, kubernetes, systemd

    if target is Target.SYSTEMD:
        return systemd.files(site)
    if target is Target.KUBERNETES:
        return kubernetes.files(site, image)
    return compose.files(site, image)


def default_image() -> str:
    """Return the name under which deploy/Dockerfile is to be built."""
    from importlib.metadata import version

    return f"sceneq:{version('sceneq')}"


def write(path: Path, text: str) -> None:
    """Write one file; raise ``UserError`` when that is impossible."""
    from sceneq_tools.errors import UserError

    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise UserError(f"{path}: {error.strerror}") from error
