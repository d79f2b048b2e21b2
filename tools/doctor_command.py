"""``sceneq doctor``: will Scene-Q run on this machine, and what mends what is wrong?"""

import json
import sys
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable

    from sceneq_tools.doctor.finding import Finding

    Examined = Iterable[tuple[str, Finding]]

NAME_WIDTH, STATE_WIDTH = 17, 9
TONES = {"ok": "good", "warning": "warn", "problem": "bad"}


def run(
    check: Annotated[
        list[str] | None, typer.Argument(metavar="CHECK", help="Only these checks.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print findings as JSON.")] = False,
    trace: Annotated[
        bool, typer.Option("--trace", help="Stop with a traceback where a check itself fails.")
    ] = False,
) -> None:
    """Check this machine; exit code 0 = nothing is in the way, 1 = something is."""
    examined = _examined(check or [], trace)
    raise typer.Exit(_tell_json(examined) if as_json else _tell(examined))


def _examined(names: list[str], trace: bool) -> "Examined":
    from sceneq_tools.doctor.examination import CHECKS, examine
    from sceneq_tools.errors import UserError

    if unknown := [name for name in names if name not in CHECKS]:
        raise UserError(f"no check named {unknown[0]!r} (there are: {', '.join(CHECKS)})", 2)
    chosen = {name: CHECKS[name] for name in names or CHECKS}
    if trace:
        return ((name, check()) for name, check in chosen.items())
    return examine(chosen)


def _tell(examined: "Examined") -> int:
    """Print each finding as soon as it is there; return the exit code."""
    from sceneq_tools.console import coloured

    paint = coloured(sys.stdout)
    counts = {"ok": 0, "warning": 0, "problem": 0}
    for name, finding in examined:
        counts[finding.state] += 1
        for line in lines(name, finding, paint):
            typer.echo(line)
    typer.echo(f"\n{verdict(counts['problem'], counts['warning'])}")
    return int(counts["problem"] > 0)


def lines(name: str, finding: "Finding", paint: "Callable[[str, str], str]") -> list[str]:
    """Return a finding as one line, and below it the command that mends it."""
    state = paint(f"{finding.state:<{STATE_WIDTH}}", TONES[finding.state])
    told = [f"{state}{name:<{NAME_WIDTH}}{' '.join(finding.found.split())}"]
    if finding.mend:
        told.append(f"{'':<{STATE_WIDTH + NAME_WIDTH}}-> {finding.mend}")
    return told


def verdict(problems: int, warnings: int) -> str:
    """Return the last line."""
    plural = "s" if problems != 1 else ""
    blocked = f"{problems} problem{plural} to mend first" if problems else "nothing is in the way"
    if not warnings:
        return blocked
    return f"{blocked}; {warnings} warning{'s' if warnings != 1 else ''}"


def _tell_json(examined: "Examined") -> int:
    found: list[dict[str, Any]] = [
        {"check": name, "state": finding.state, "found": finding.found, "mend": finding.mend}
        for name, finding in examined
    ]
    fine = all(one["state"] != "problem" for one in found)
    typer.echo(json.dumps({"ok": fine, "checks": found}, ensure_ascii=False, indent=2))
    return int(not fine)
