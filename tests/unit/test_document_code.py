"""Code in the documents: Python that runs, graphs and backends that our own reader accepts."""

import ast
import re
import sys
import textwrap
import tomllib
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
import yaml

from sceneq_nodes._backends import BACKENDS, build, check
from sceneq_tools.graph import load
from sceneq_tools.graph_check import check_nodes

from support.documents import Block, blocks, pages
from support.room import Room
from support.true_map import frame_of

PAGES = pages()
BLOCKS = [block for page in PAGES for block in blocks(page)]
RUN_THERE = {"docs/client.md", "docs/proposals.md"}
"""Pages whose Python integration/test_documents.py runs, beside a graph and before a map."""
SPEC = re.compile(r"\b(encoder|segmenter|source|proposals|reasoner|odometry|keyframes): (\{.*?\})")


def where(block: Block) -> str:
    return f"{block.page}:{block.line}"


@pytest.fixture
def one_colour(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """The segmenter of docs/backends.md, installed."""
    (block,) = [b for b in BLOCKS if b.page == "docs/backends.md" and b.language == "python"]
    module = ModuleType("my_package")
    monkeypatch.setitem(sys.modules, "my_package", module)
    exec(block.text, module.__dict__)
    (points,) = [b for b in BLOCKS if b.page == "docs/backends.md" and b.language == "toml"]
    (group,) = tomllib.loads(points.text)["project"]["entry-points"].items()
    seam = group[0].removeprefix("sceneq.")
    for kind, target in group[1].items():
        monkeypatch.setitem(BACKENDS[seam], kind, target)
    return module


def test_the_backend_of_the_page_works(one_colour: ModuleType) -> None:
    segmenter = build("segmenter", {"kind": "one_colour", "step": 32})
    frame, things = frame_of(Room(), 0, 4)
    labels = segmenter.segment(frame)
    assert (labels.shape, labels.dtype) == (things.shape, np.uint16)
    ball = labels[things == 4]  # red, and nothing else is
    assert not set(np.unique(ball)) & set(np.unique(labels[things == 5]))


def test_all_python_runs_somewhere() -> None:
    found = {block.page for block in BLOCKS if block.language == "python"}
    assert found == RUN_THERE | {"docs/backends.md"}


@pytest.mark.parametrize("block", BLOCKS, ids=where)
def test_it_can_be_read(block: Block) -> None:
    readers = {"python": ast.parse, "json": yaml.safe_load, "toml": tomllib.loads}
    if block.language in readers:
        assert readers[block.language](block.text)


def graphs() -> Iterator[Block]:
    """Yield blocks with nodes."""
    for block in BLOCKS:
        text = textwrap.dedent(block.text)
        if block.language in ("", "yaml") and re.search(r"^(- id:|nodes:)", text, re.M):
            yield block


@pytest.mark.parametrize("block", list(graphs()), ids=where)
def test_graphs_are_right(block: Block, one_colour: ModuleType, tmp_path: Path) -> None:
    told: Any = yaml.safe_load(textwrap.dedent(block.text))
    told = {"scene": "room", **(told if isinstance(told, dict) else {"nodes": told})}
    (tmp_path / "graph.yaml").write_text(yaml.safe_dump(told))
    graph, document = load(tmp_path / "graph.yaml", [])
    check_nodes(graph, document)
    assert len(graph.nodes) == len(told["nodes"])


def specs() -> Iterator[tuple[str, str, str]]:
    for page in PAGES:
        for seam, spec in SPEC.findall((Path(__file__).parents[2] / page).read_text()):
            if spec.count("{") == spec.count("}") and "kind:" in spec and "..." not in spec:
                yield page, seam, spec


@pytest.mark.parametrize(("page", "seam", "spec"), list(specs()))
def test_kinds_and_their_parameters_are_known(
    one_colour: ModuleType, page: str, seam: str, spec: str
) -> None:
    told = yaml.safe_load(spec)
    if told["kind"] == "files":
        told |= {"path": "masks"}  # the command line fills it in
    kind, params = check(seam, told)
    assert isinstance(params, kind.Params)
