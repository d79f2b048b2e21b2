"""``sceneq portraits`` and ``sceneq train-probe`` teach the embedded encoder names of things.

Typed as the records of decisions have them, with what support/command_ways.py says behind them, on
one room and on portraits of the one model of a library.
"""

import re

import numpy as np
import pytest
import yaml

from sceneq_nodes._backends import build
from sceneq_nodes._calibration import read_calibration
from sceneq_nodes._probe_file import HOUSEHOLD, read_probe
from sceneq_tools.graph import default_path
from sceneq_tools.room.models.libraries import FOLDER_VARIABLE
from sceneq_tools.room.portrait.album import pages

from support.command_ways import row_of, shortened
from support.furniture import CATALOGUE, write_library
from support.questioned import write_questioned
from support.reader import Reader
from support.tiny_suite import write_suite

PROBE = "nodes/household_probe.npz"
WITH_A_SOFA = CATALOGUE.replace("Test#stool", "Scopia#simple_sofa")

pytestmark = pytest.mark.integration


@pytest.fixture
def reader(tmp_path_factory: pytest.TempPathFactory) -> Reader:
    """A person with a room of `sceneq synth`."""
    folder = tmp_path_factory.mktemp("taught")
    write_questioned(folder / "rooms" / "room")
    return Reader(folder, folder)


def typed(reader: Reader, pattern: str) -> str:
    """Type the documented command that matches; return what it printed."""
    (command,) = (one for one in shortened(__file__) if re.match(pattern, one.text))
    return reader.succeeds(command.text, *row_of(command).more.split(), "--quiet").printed


def test_every_command_is_typed_here() -> None:
    assert len(shortened(__file__)) == 5


def test_what_was_taught_can_be_asked(reader: Reader) -> None:
    printed = typed(reader, r"sceneq train-probe rooms/\* --out")
    assert printed.endswith(f"-> {PROBE}\n")
    probe = reader.folder / PROBE
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


def test_portraits_teach_beside_rooms(reader: Reader, monkeypatch: pytest.MonkeyPatch) -> None:
    furniture = reader.folder / "furniture"
    furniture.mkdir()
    write_library(furniture, catalogue=WITH_A_SOFA)
    monkeypatch.setenv(FOLDER_VARIABLE, str(furniture))
    taken = re.match(r"(\d+) portraits of 1 rooms", typed(reader, "sceneq portraits"))
    assert taken is not None
    portraits = list(pages(reader.folder / "portraits"))
    assert len(portraits) == int(taken[1]) > 0
    assert {one.name for one in portraits} == {"sofa"}
    typed(reader, r"sceneq train-probe rooms/\* portraits portraits --out")
    names = read_probe(reader.folder / PROBE).lessons.probe.names
    assert {"ball", "table", "sofa"} <= set(names)
    typed(reader, r"sceneq train-probe rooms/\* portraits portraits --withhold")
    (stranger,) = (reader.folder / "strangers").glob("*.npz")
    assert read_probe(stranger).lessons.probe.names == names
    assert read_probe(stranger).withheld == ("Scopia#simple_sofa",)
    calibrated_with_strangers(reader)


def calibrated_with_strangers(reader: Reader) -> None:
    """The graph has to have the probe that the strangers were made beside."""
    graph = yaml.safe_load(default_path().read_text())
    for node in graph["nodes"]:
        if node["id"] in ("encoding", "routing"):
            probe = {"kind": "conse", "probe": str(reader.folder / PROBE)}
            node["params"] = {**node["params"], "encoder": probe}
    (reader.folder / "graph.yaml").write_text(yaml.safe_dump(graph))
    write_suite(reader.folder / "suite")
    printed = typed(reader, r"sceneq calibrate suite --maps maps --strangers")
    assert "unfamiliar: Unfamiliar(" in printed
    made = read_calibration(reader.folder / "calibration.json")
    assert made.unfamiliar is not None
    assert made.unfamiliar.slope > 0
