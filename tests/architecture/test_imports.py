"""tools -> nodes -> {core, schemas}; core is pure; one file knows the bus."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = {
    "sceneq_core": ROOT / "sceneq_core",
    "sceneq_nodes": ROOT / "nodes",
    "sceneq_schemas": ROOT / "schemas",
    "sceneq_tools": ROOT / "tools",
    "sceneq_client": ROOT / "tools" / "client",
}
ALLOWED = {
    "sceneq_core": {"sceneq_core"},
    "sceneq_schemas": {"sceneq_schemas"},
    "sceneq_nodes": {"sceneq_nodes", "sceneq_core", "sceneq_schemas"},
    "sceneq_client": {"sceneq_client", "sceneq_nodes", "sceneq_core", "sceneq_schemas"},
    "sceneq_tools": {
        *("sceneq_tools", "sceneq_client", "sceneq_nodes", "sceneq_core", "sceneq_schemas")
    },
}
BUS = ROOT / "nodes" / "_runtime.py"
FOREIGN_KEYS = ROOT / "nodes" / "_foreign.py"
"""The other half of the runtime: keys that are not in the table of topics."""
IMPURE = {
    "zenoh", "msgpack", "pydantic", "pathlib", "os", "io", "time", "datetime", "random",
    "socket", "subprocess", "multiprocessing", "tempfile", "shutil", "logging",
}  # fmt: skip
SCHEMAS_MAY_USE = {"numpy", "msgpack"}


def modules(package: str) -> list[Path]:
    return sorted(FOLDERS[package].rglob("*.py"))


def imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield node.module or ""


def package_of(name: str) -> str:
    return name.partition(".")[0]


@pytest.mark.parametrize("package", FOLDERS)
def test_a_package_imports_only_what_lies_below_it(package: str) -> None:
    for path in modules(package):
        ours = {package_of(n) for n in imports(path)} & set(FOLDERS)
        assert ours <= ALLOWED[package], f"{path.relative_to(ROOT)} imports {ours}"


def test_only_the_runtime_imports_zenoh() -> None:
    users = {
        path
        for package in FOLDERS
        for path in modules(package)
        if "zenoh" in {package_of(n) for n in imports(path)}
    }
    assert users == {BUS, FOREIGN_KEYS}


def test_core_has_no_bus_no_files_and_no_clock() -> None:
    for path in modules("sceneq_core"):
        impure = {package_of(n) for n in imports(path)} & IMPURE
        assert not impure, f"{path.relative_to(ROOT)} imports {impure}"
        calls = {
            node.func.id
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        }
        assert "open" not in calls, f"{path.relative_to(ROOT)} opens a file"


def test_schemas_need_numpy_and_msgpack_only() -> None:
    import sys

    for path in modules("sceneq_schemas"):
        foreign = {package_of(n) for n in imports(path)} - sys.stdlib_module_names
        assert foreign <= SCHEMAS_MAY_USE | {"sceneq_schemas"}, path


def test_no_node_imports_another_node() -> None:
    nodes = {p.stem for p in modules("sceneq_nodes") if not p.stem.startswith("_")}
    for path in modules("sceneq_nodes"):
        imported = {n.removeprefix("sceneq_nodes.") for n in imports(path)}
        assert not imported & nodes, f"{path.name} imports {imported & nodes}"


def test_light_processes_do_not_load_heavy_libraries_at_import() -> None:
    heavy = {"torch", "open3d", "onnxruntime", "kiss_icp", "rerun", "onnx"}
    for package in FOLDERS:
        for path in modules(package):
            tops = {
                package_of(name)
                for node in ast.parse(path.read_text()).body
                if isinstance(node, ast.Import | ast.ImportFrom)
                for name in (
                    [a.name for a in node.names]
                    if isinstance(node, ast.Import)
                    else [node.module or ""]
                )
            }
            assert not tops & heavy, f"{path.relative_to(ROOT)} imports {tops & heavy} at the top"
