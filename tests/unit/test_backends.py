"""Backends by kind: ours, those of third parties, and what is said when there is none."""

import importlib
import importlib.metadata
import subprocess
import sys
from dataclasses import dataclass
from importlib.metadata import EntryPoint
from typing import Any, ClassVar

import pytest

from sceneq_nodes import NODES
from sceneq_nodes._backends import BACKENDS, build, check, kinds, load
from sceneq_nodes._params import ParamError


class Pencil:
    """A backend as a third party would write it."""

    @dataclass(frozen=True, slots=True)
    class Params:
        """Its width."""

        width_mm: float = 0.5

    def __init__(self, params: Params) -> None:
        self.params = params


@dataclass(frozen=True, slots=True)
class Kind:
    """Something that has no ``Params``."""

    Params: ClassVar[Any] = None


@pytest.fixture(autouse=True)
def plugins(monkeypatch: pytest.MonkeyPatch) -> None:
    """Register this file's classes as entry points of the seam ``tool``."""
    module = type("module", (), {"Pencil": Pencil})

    def fake_entry_points(group: str) -> list[EntryPoint]:
        if group != "sceneq.tool":
            return []
        return [
            EntryPoint("pencil", "a_plugin:Pencil", group),
            EntryPoint("broken", "no_such_plugin:Pen", group),
            EntryPoint("empty", "a_plugin:Pen", group),
        ]

    real = importlib.import_module
    monkeypatch.setattr(importlib.metadata, "entry_points", fake_entry_points)
    monkeypatch.setattr(
        importlib,
        "import_module",
        lambda name, package=None: module if name == "a_plugin" else real(name, package),
    )
    monkeypatch.setitem(BACKENDS, "tool", {})


def test_a_plugin_is_built_with_its_parameters() -> None:
    pencil = build("tool", {"kind": "pencil", "width_mm": 1})
    assert isinstance(pencil, Pencil)
    assert pencil.params == Pencil.Params(1.0)


def test_check_builds_nothing() -> None:
    assert check("tool", {"kind": "pencil"}) == (Pencil, Pencil.Params())


@pytest.mark.parametrize(
    ("spec", "says"),
    [
        ({}, "p.kind: missing key (add 'kind: ...')"),
        ("pencil", "p.kind: missing key"),
        ({"kind": "pensil"}, "p.kind: unknown kind (did you mean 'pencil'?)"),
        ({"kind": "pencil", "width": 1}, "p.width: unknown key (did you mean 'width_mm'?)"),
        ({"kind": "broken"}, "p.kind: cannot load no_such_plugin:Pen: No module named"),
        ({"kind": "empty"}, "p.kind: cannot load a_plugin:Pen:"),
    ],
)
def test_what_cannot_be_built_is_named_with_its_place(spec: Any, says: str) -> None:
    with pytest.raises(ParamError) as caught:
        build("tool", spec, ("p",))
    assert str(caught.value).startswith(says)


def test_ours_cannot_be_replaced_by_a_plugin(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BACKENDS, "tool", {"pencil": "ours:Pencil"})
    assert kinds("tool")["pencil"] == "ours:Pencil"
    assert set(kinds("tool")) == {"pencil", "broken", "empty"}


@pytest.mark.parametrize("kind", NODES)
def test_every_node_of_ours_loads(kind: str) -> None:
    node_class = load("nodes", kind)
    assert node_class.idle_s >= 0
    assert node_class.Params.__dataclass_params__.frozen


def test_nodes_load_without_the_heavy_libraries() -> None:
    """A killed node has to be back within two seconds."""
    code = (
        "import sys; from sceneq_nodes._backends import load, NODES;"
        "[load('nodes', kind) for kind in NODES];"
        "print(*sorted({'torch', 'open3d', 'onnxruntime', 'kiss_icp'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert done.stdout == "\n"


@pytest.mark.parametrize(
    ("seam", "kind"),
    [(seam, kind) for seam in BACKENDS if seam != "nodes" for kind in BACKENDS[seam]],
)
def test_every_backend_of_ours_loads(seam: str, kind: str) -> None:
    assert load(seam, kind).Params.__dataclass_params__.frozen
