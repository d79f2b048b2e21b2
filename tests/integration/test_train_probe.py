"""``sceneq train-probe`` teaches the embedded encoder the things of a recording."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sceneq_nodes._backends import build
from sceneq_nodes._probe_file import HOUSEHOLD, read_probe
from sceneq_tools.cli import app

from support.questioned import write_questioned

pytestmark = pytest.mark.integration


def test_what_was_taught_can_be_asked(tmp_path: Path) -> None:
    room, probe = write_questioned(tmp_path / "room"), tmp_path / "taught" / "probe.npz"
    options = ["--out", str(probe), "--rounds", "3", "--quiet"]
    done = CliRunner().invoke(app, ["train-probe", str(room), *options])
    assert (done.exit_code, done.exception) == (0, None)
    assert done.stdout.endswith(f"-> {probe}\n")
    file = read_probe(probe)
    names = file.lessons.probe.names
    assert {"ball", "box", "table"} <= set(names)
    taught = build("encoder", {"kind": "conse", "probe": str(probe)})
    usual = build("encoder", {"kind": "conse"})
    assert taught.model_id != usual.model_id
    assert taught.dim == usual.dim - len(read_probe(HOUSEHOLD).lessons.probe) + len(names)
    ball, table = taught.encode_texts(["ball", "table"])
    assert ball[1000 + names.index("ball")] > 0.3 > table[1000 + names.index("ball")]
    sizes = file.lessons.sizes.mean
    assert sizes[names.index("table"), 0] > sizes[names.index("ball"), 0]
    assert len(file.taught_with) == 16
    assert np.linalg.norm(ball) == pytest.approx(1, abs=1e-5)
