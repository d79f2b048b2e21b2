"""Sizes, packaging and wording of the code itself."""

import ast
import re
import statistics
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("sceneq_core", "nodes", "schemas", "tools")
SOURCES = sorted(p for name in PACKAGES for p in (ROOT / name).rglob("*.py"))
UNFINISHED = re.compile(r"\b(TODO|FIXME|XXX|HACK)\b")


def functions(path: Path) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
    tree = ast.parse(path.read_text())
    return [n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef)]


def length(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Count the lines of code, docstring not included: explaining is not to be punished."""
    body = function.body[1:] if ast.get_docstring(function) else function.body
    if not body:
        return 0
    return (function.end_lineno or 0) - body[0].lineno + 1


def test_files_stay_under_300_lines() -> None:
    long = {p.relative_to(ROOT): n for p in SOURCES if (n := len(p.read_text().splitlines())) > 300}
    assert not long


def test_no_function_is_longer_than_60_lines_and_most_are_small() -> None:
    lengths = {
        f"{p.relative_to(ROOT)}:{f.name}": f.end_lineno - f.lineno + 1
        for p in SOURCES
        for f in functions(p)
        if f.end_lineno
    }
    assert not {name: n for name, n in lengths.items() if n > 60}
    assert statistics.median(length(f) for p in SOURCES for f in functions(p)) <= 8


def test_every_package_folder_is_in_the_wheel() -> None:
    config = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    names = {folder: package for package, folder in config["package-dir"].items()}
    assert set(names) == {*PACKAGES, "tools/client"}

    def package(folder: Path) -> str:
        above = next(f for f in (folder, *folder.parents) if f.as_posix() in names)
        return ".".join((names[above.as_posix()], *folder.relative_to(above).parts))

    folders = {package(path.parent.relative_to(ROOT)) for path in SOURCES}
    assert folders == set(config["packages"])


def test_nothing_is_left_unfinished_or_swallowed() -> None:
    for path in SOURCES:
        text = path.read_text()
        assert not UNFINISHED.search(text), path
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ExceptHandler) and _catches_everything(node):
                assert not all(isinstance(b, ast.Pass | ast.Continue) for b in node.body), path


def _catches_everything(handler: ast.ExceptHandler) -> bool:
    name = getattr(handler.type, "id", "")
    return handler.type is None or name in ("Exception", "BaseException")


def test_the_top_level_is_the_agreed_one() -> None:
    agreed = {
        "graph.yaml", "nodes", "sceneq_core", "schemas", "tools", "tests", "pyproject.toml",
        "README.md", "LICENSE", "CITATION.cff", "Makefile", "docs", "deploy", ".ci", ".github",
        ".gitignore", "requirements.lock",
    }  # fmt: skip
    import subprocess

    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.splitlines()
    assert {Path(name).parts[0] for name in listed} <= agreed


def test_every_seam_has_a_contract_test_over_all_its_kinds() -> None:
    from sceneq_nodes._backends import BACKENDS

    texts = [path.read_text() for path in (ROOT / "tests" / "contract").glob("test_*.py")]
    untested = {
        seam for seam in BACKENDS if not any(f'kinds("{seam}")' in text for text in texts)
    } - {"nodes"}  # a node is tested on the fake bus, not as a backend
    assert not untested
