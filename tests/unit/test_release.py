"""What is released says one version, may be given away, and tells all that is in it."""

import importlib.util
import json
import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import metadata, version
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import yaml
from packaging.specifiers import SpecifierSet

from sceneq_nodes.web.openapi import document

ROOT = Path(__file__).parents[2]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]


@pytest.fixture(scope="module")
def licences() -> ModuleType:
    spec = importlib.util.spec_from_file_location(
        "site_licences", ROOT / "deploy" / "site" / "licences.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def test_the_version_is_that_of_pyproject_everywhere() -> None:
    told = PROJECT["version"]
    assert version("sceneq") == told
    assert document()["info"]["version"] == told
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == told
    for path in ("deploy/Dockerfile", "docs/deployment.md"):
        named = set(re.findall(r"sceneq:(\d+\.\d+\.\d+)", (ROOT / path).read_text()))
        assert named <= {told}, path
    printed = subprocess.run(
        [sys.executable, "-m", "sceneq_tools", "--version"], capture_output=True, text=True
    )
    assert printed.stdout.split()[-1] == told


def test_the_version_is_written_into_no_source() -> None:
    quoted = re.compile(rf"""["']{re.escape(PROJECT["version"])}["']""")
    for folder in ("nodes", "sceneq_core", "schemas", "tools"):
        for path in (ROOT / folder).rglob("*.py"):
            assert not quoted.search(path.read_text()), path


def test_pythons_are_declared_alike() -> None:
    declared = [
        one.rpartition(" ")[2]
        for one in PROJECT["classifiers"]
        if re.search(r"Python :: 3\.\d+$", one)
    ]
    accepted = SpecifierSet(PROJECT["requires-python"])
    assert declared == [f"3.{minor}" for minor in range(30) if f"3.{minor}.0" in accepted]
    assert SpecifierSet(metadata("sceneq")["Requires-Python"]) == accepted


def test_a_citation_names_the_paper_and_whoever_wrote_it() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert cited["license"] == PROJECT["license"]
    paper = cited["references"][0]
    assert paper["type"] == "conference-paper"
    assert [one["family-names"] for one in paper["authors"]] == ["Kim", "Park", "Yoon", "Zhang"]


def test_the_changelog_keeps_its_form() -> None:
    log = (ROOT / "docs" / "changelog.md").read_text()
    versions = re.findall(r"^## (.+)$", log, re.MULTILINE)
    assert versions[0] == "Unreleased"
    assert all(re.fullmatch(r"\[\d+\.\d+\.\d+\] - \d{4}-\d\d-\d\d", v) for v in versions[1:])
    kinds = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
    assert set(re.findall(r"^### (.+)$", log, re.MULTILINE)) <= kinds


def test_forms_to_report_by_can_be_read() -> None:
    forms = [yaml.safe_load(p.read_text()) for p in (ROOT / ".github" / "ISSUE_TEMPLATE").iterdir()]
    filled = [form for form in forms if "body" in form]
    assert len(filled) == 3
    for form in filled:
        assert {"name", "description", "body"} <= set(form)
        ids = [part["id"] for part in form["body"]]
        assert len(set(ids)) == len(ids)
        assert all(part["attributes"]["label"] for part in form["body"])


def test_the_licence_of_everything_locked_is_known_and_allowed(licences: ModuleType) -> None:
    rules = licences.rules()
    packages = licences.locked(rules)
    assert licences.refused(packages, rules) == []
    names = {one.name for one in packages}
    assert {"numpy", "torch", "eclipse-zenoh", "nvidia-cublas", "pytest"} <= names
    assert set(rules["declared"]) <= names
    assert {p.name: p.needed for p in packages}["starlette"] == licences.RUN
    assert f"| {packages[0].name} |" in licences.page(packages)


@pytest.mark.parametrize(
    ("licence", "allowed"),
    [
        ("MIT", True),
        ("GPL-3.0-only", False),
        ("GPL-3.0-only OR MIT", True),
        ("MIT AND (GPL-3.0-only OR Apache-2.0)", True),
        ("MIT AND GPL-3.0-only", False),
        ("Apache-2.0 WITH LLVM-exception", True),
        ("see LICENSE.txt, (c) somebody", False),
        ("", False),
    ],
)
def test_a_licence_is_allowed_when_one_may_choose_so(
    licences: ModuleType, licence: str, *, allowed: bool
) -> None:
    rules = licences.rules()
    assert licences.allows(rules["allowed"], licence) is allowed
    stranger = licences.Locked("stranger", ("1",), licences.RUN, licence)
    assert (licences.refused([stranger], rules) == []) is allowed


def test_the_bill_of_materials_has_what_is_locked(licences: ModuleType, tmp_path: Path) -> None:
    """Only made: ``make sbom`` also validates it, which takes twenty times as long."""
    out = tmp_path / "sbom.json"
    subprocess.run(
        [ROOT / ".ci" / "sbom", out, "--no-validate"],
        env=os.environ | {"PYTHON": sys.executable},
        check=True,
        capture_output=True,
    )
    bill = json.loads(out.read_text())
    assert (bill["bomFormat"], bill["metadata"]["component"]["name"]) == ("CycloneDX", "sceneq")
    assert bill["metadata"]["component"]["version"] == PROJECT["version"]
    built = {licences.canonicalize_name(one["name"]) for one in bill["components"]}
    needed = {p.name for p in licences.locked(licences.rules()) if p.needed == licences.RUN}
    assert {one for one in needed if licences.is_installed(one)} <= built
    assert all(one["purl"].startswith("pkg:pypi/") for one in bill["components"])
