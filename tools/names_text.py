"""Taught names in words and columns."""

from collections.abc import Mapping, Sequence
from typing import Any

import typer

COLUMNS = ("name", "kind", "is", "p", "inherited by", "alike", "taught by", "when")
SHOWN = 6
Body = Mapping[str, Any]


def taught(body: Body) -> None:
    """Say what was taught, in place of what and who inherits it."""
    typer.echo(f"instance {body['id']} is '{body['name']}' ({body['kind']}, p {body['p']:g})")
    for old in body.get("replaced", ()):
        typer.echo(f"before, '{old['name']}' was {_where(old)}, {_origin(old)}")
    if others := body.get("pointed_at", ())[1:]:
        typer.echo(f"also there: {', '.join(map(str, others))}")
    if body.get("inherited"):
        typer.echo(f"inherited by {_told(body['inherited'])}")
    if body.get("maybe"):
        typer.echo(f"somewhat alike: {_told(body['maybe'])}")
    _kept(body)


def forgotten(body: Body) -> None:
    """Say which names were taken back."""
    for one in body["names"]:
        typer.echo(f"forgotten: '{one['name']}' ({_where(one)}), {_origin(one)}")
    _kept(body)


def listed(body: Body) -> None:
    """Print a table of names."""
    from sceneq_tools.table import print_table

    if body["names"]:
        print_table(COLUMNS, [_row(one) for one in body["names"]])
    else:
        typer.echo('nothing was taught: sceneq teach ID "name" does')
    _kept(body)


def _row(one: Body) -> tuple[str, ...]:
    p = f"{one['p']:.2f}" if one["p"] else "-"
    heirs, maybe = _told(one["inherited"]), _told(one.get("maybe", ()))
    cells = (one["name"], one["kind"], _where(one), p, heirs or "-", maybe or "-")
    return (*cells, one["by"], one["when"])


def _where(one: Body) -> str:
    if one["id"] is not None:
        return f"instance {one['id']}"
    return "unattached, last at {:.2f} {:.2f} {:.2f} m".format(*one["centre"])


def _told(heirs: Sequence[Body]) -> str:
    more = f", {len(heirs) - SHOWN} more" if len(heirs) > SHOWN else ""
    return ", ".join(f"{heir['id']} (p {heir['p']:.2f})" for heir in heirs[:SHOWN]) + more


def _origin(one: Body) -> str:
    return f"taught by {one['by']} on {one['when']}"


def _kept(body: Body) -> None:
    if not body.get("kept"):
        typer.echo("kept in memory only: a graph started with --store DIR remembers names")
    if body.get("problem"):
        typer.echo(f"the file of names: {body['problem']}", err=True)
