"""The licences of all that is locked: a page of the site, and what a test refuses.

A package says its licence in its metadata: as an SPDX expression (PEP 639), as a classifier, or in
words that happen to be SPDX. ``deploy/licences.toml`` says it for those that do not.
"""

import re
import tomllib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, distribution, requires
from pathlib import Path
from typing import Any

from license_expression import ExpressionError, Licensing
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

DEPLOY = Path(__file__).parents[1]
RUN, DEVELOP, CUDA, ELSEWHERE = "run", "develop", "GPU", "other systems"
PINNED = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;]+)", re.MULTILINE)
OF_CLASSIFIER = {
    "Apache Software License": "Apache-2.0",
    "BSD License": "BSD",
    "ISC License (ISCL)": "ISC",
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0",
    "Other/Proprietary License": "",
}
SPDX = Licensing()


@dataclass(frozen=True)
class Locked:
    """A package of the lock files; ``licence`` is "" when nobody says it."""

    name: str
    versions: tuple[str, ...]
    needed: str
    licence: str


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the page."""
    files.append(File.generated(config, "licences.md", content=page(locked(rules()))))
    return files


def rules() -> dict[str, Any]:
    """Return what ``deploy/licences.toml`` says."""
    return tomllib.loads((DEPLOY / "licences.toml").read_text())


def locked(rules: dict[str, Any]) -> list[Locked]:
    """Return every package of the lock files, by name."""
    versions: dict[str, list[str]] = {}
    cuda = set()
    for path in sorted(DEPLOY.glob("*.lock")):
        for name, version in PINNED.findall(path.read_text()):
            versions.setdefault(canonicalize_name(name), []).append(version)
            if path.name == "cuda.lock":
                cuda.add(canonicalize_name(name))
    to_run = needed_by("sceneq")
    return [
        Locked(
            name,
            tuple(sorted(set(versions[name]))),
            CUDA if name in cuda else needed(name, to_run),
            rules["declared"].get(name) or said_by(name),
        )
        for name in sorted(versions)
    ]


def needed(package: str, to_run: set[str]) -> str:
    """Tell what a package is there for; what is not installed here is for other systems."""
    if package in to_run:
        return RUN
    return DEVELOP if is_installed(package) else ELSEWHERE


def is_installed(package: str) -> bool:
    """Tell whether this environment has it."""
    try:
        distribution(package)
    except PackageNotFoundError:
        return False
    return True


def needed_by(package: str) -> set[str]:
    """Return what ``package`` needs to run here, and what that needs."""
    found: set[str] = set()
    waiting = [package]
    while waiting:
        for one in _required(waiting.pop()):
            if one not in found:
                found.add(one)
                waiting.append(one)
    return found


def _required(package: str) -> Iterator[str]:
    texts = (requires(package) or []) if is_installed(package) else []
    for requirement in map(Requirement, texts):
        if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
            yield canonicalize_name(requirement.name)


def said_by(package: str) -> str:
    """Return the licence that an installed package's metadata tells, "" when it tells none."""
    if not is_installed(package):
        return ""
    told = distribution(package).metadata
    if expression := told.get("License-Expression"):
        return str(expression)
    classifiers = [
        c.split(" :: ")[-1] for c in told.get_all("Classifier") or [] if "License ::" in c
    ]
    known = {OF_CLASSIFIER.get(one, "") for one in classifiers if one != "OSI Approved"}
    words = str(told.get("License") or "")
    return known.pop() if len(known) == 1 else words


def allows(allowed: Iterable[str], licence: str) -> bool:
    """Tell whether ``licence``, an SPDX expression, lets us choose only what is ``allowed``."""
    try:
        choice = SPDX.parse(licence)
    except ExpressionError:
        return False
    return choice is not None and _holds(choice, set(allowed))


def _holds(choice: Any, allowed: set[str]) -> bool:
    if isinstance(choice, SPDX.AND):
        return all(_holds(part, allowed) for part in choice.args)
    if isinstance(choice, SPDX.OR):
        return any(_holds(part, allowed) for part in choice.args)
    return str(choice) in allowed


def refused(packages: Iterable[Locked], rules: dict[str, Any]) -> list[str]:
    """Return a line for each package whose licence is not allowed, or not known."""
    return [
        f"{one.name}: {one.licence[:60] or 'unknown'}"
        for one in packages
        if not allows(rules["allowed_cuda" if one.needed == CUDA else "allowed"], one.licence)
    ]


def page(packages: Iterable[Locked]) -> str:
    """Return the table, in Markdown."""
    rows = [f"| {p.name} | {', '.join(p.versions)} | {p.needed} | {p.licence} |" for p in packages]
    about = (
        "Scene-Q itself is Apache-2.0. This is all that its lock files name, with the licences as "
        "SPDX writes them: what it needs to run, what it takes to develop it, what a build of "
        "torch for a GPU brings, and what only other systems need. "
        "`deploy/licences.toml` says which are allowed."
    )
    head = "| package | version | to | licence |\n|---|---|---|---|"
    return "\n\n".join(["# Licences", about, "\n".join([head, *rows])]) + "\n"
