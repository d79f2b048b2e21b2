"""Which calibration an encoder gets."""

import json
from pathlib import Path

import pytest

from sceneq_core.routing.gate import GateParams
from sceneq_nodes import _chosen_calibration
from sceneq_nodes._calibration import Calibration, read_calibration
from sceneq_nodes._chosen_calibration import SHIPPED, chosen_calibration, former_calibration

from support.furnished import WordEncoder

WORDS = Calibration("words", 0.05, GateParams())


class OtherEncoder(WordEncoder):
    model_id = "other"


def write(folder: Path, calibration: Calibration, name: str) -> Path:
    path = folder / name
    path.write_text(json.dumps(calibration.as_dict()))
    return path


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    write(tmp_path, WORDS, "words.json")
    monkeypatch.setattr(_chosen_calibration, "SHIPPED", tmp_path)
    return tmp_path


def test_the_shipped_one_is_taken_when_it_is_the_encoders(shipped):
    assert chosen_calibration("", WordEncoder()) == WORDS
    assert chosen_calibration("", OtherEncoder()) is None


def test_none_switches_it_off(shipped):
    assert chosen_calibration("none", WordEncoder()) is None
    assert former_calibration("none", WordEncoder()) is None


def test_a_path_is_taken_instead_and_must_be_the_encoders(shipped):
    mine = Calibration("words", 0.2, GateParams())
    path = write(shipped, mine, "mine.json")
    assert chosen_calibration(str(path), WordEncoder()) == mine
    with pytest.raises(ValueError, match="made for the encoder 'words', this one is 'other'"):
        chosen_calibration(str(path), OtherEncoder())


def test_an_encoder_that_goes_keeps_what_is_its_own(shipped):
    new = write(shipped, Calibration("other", 0.2, GateParams()), "new.json")
    assert former_calibration(str(new), WordEncoder()) == WORDS
    assert former_calibration(str(new), OtherEncoder()) == read_calibration(new)
    assert former_calibration("", WordEncoder()) == WORDS


def test_what_is_shipped_can_be_read_and_is_named_by_its_encoder():
    files = sorted(SHIPPED.glob("*.json"))
    assert files
    for path in files:
        calibration = read_calibration(path)
        assert path.stem == calibration.encoder
        assert calibration.null is not None
        assert calibration.sha256
