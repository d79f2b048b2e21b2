"""A calibration on disk: what is in it, what is refused, and what it changes."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sceneq_core.routing.gate import GateParams
from sceneq_core.routing.labels import custom, named
from sceneq_core.routing.null import NullParams
from sceneq_core.routing.router import RouterParams
from sceneq_core.routing.sureness import Sureness
from sceneq_core.routing.unfamiliar import Unfamiliar
from sceneq_nodes._calibration import Calibration, read_calibration
from sceneq_nodes._new_router import new_router

from support.furnished import WordEncoder, snapshot

GATE = GateParams(min_p=0.4, min_margin=0.1, max_entropy_norm=0.6, clear_margin=0.3)
NULL = NullParams(temperature=0.05, name=1.0, said=0.5, standing=2.0, bias=-3.0)
DESCRIBED = NullParams(temperature=0.1, name=0.2, said=0.0, standing=0.5, bias=1.0)
SURENESS = Sureness(slope=0.7, shift=0.2)
UNFAMILIAR = Unfamiliar(0.09, 0.8, 150.0, NULL, DESCRIBED, SURENESS)
CALIBRATION = Calibration(
    *("words", 0.07, GATE, NULL, "scannet200", ("a" * 64,)),
    *(DESCRIBED, SURENESS, UNFAMILIAR),
)


V5 = ("unfamiliar",)
NEWEST = ("sureness_described", *V5)


@pytest.fixture(autouse=True)
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def write(folder: Path, document: object) -> Path:
    path = folder / "calibration.json"
    path.write_text(json.dumps(document))
    return path


def test_what_is_written_is_read_again(tmp_path):
    document = {**CALIBRATION.as_dict(), "date": "today", "recordings": ["room"]}
    assert read_calibration(write(tmp_path, document)) == CALIBRATION
    nothing_absent = replace(CALIBRATION, null=None, null_described=None, sureness_described=None)
    assert read_calibration(write(tmp_path, nothing_absent.as_dict())) == nothing_absent
    bare = replace(UNFAMILIAR, null=None, null_described=None, sureness_described=None)
    others = [replace(CALIBRATION, unfamiliar=one) for one in (None, bare)]
    for other in others:
        assert read_calibration(write(tmp_path, other.as_dict())) == other


def test_the_name_tells_the_encoder_and_changes_with_every_number():
    others = (
        replace(CALIBRATION, temperature=0.08),
        replace(CALIBRATION, null=None),
        replace(CALIBRATION, null_described=None),
        replace(CALIBRATION, sureness_described=None),
        replace(CALIBRATION, unfamiliar=None),
        replace(CALIBRATION, gate=GateParams()),
        replace(CALIBRATION, sha256=("b" * 64,)),
    )
    names = {one.name for one in (CALIBRATION, *others)}
    assert len(names) == 8
    assert all(len(name) == len("words:12345678") for name in names)
    assert all(name.startswith("words:") for name in names)


@pytest.mark.parametrize(
    ("version", "missing", "lacks"),
    [
        ("v1", ("null", "null_described", *NEWEST), "knows no 'none of them'"),
        ("v2", ("null_described", *NEWEST), "does not tell what is named from what is described"),
        ("v3", NEWEST, "does not know how sure a first guess for a description is"),
        ("v4", V5, "does not tell familiar scenes from unfamiliar ones"),
    ],
)
def test_files_of_former_formats_are_refused_with_what_to_do(tmp_path, version, missing, lacks):
    former = {**CALIBRATION.as_dict(), "format": f"sceneq.calibration.{version}"}
    for name in missing:
        del former[name]
    with pytest.raises(ValueError, match=rf"{version}' {lacks} \(make a new one: sceneq"):
        read_calibration(write(tmp_path, former))


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"format": "other"}, "format"),
        ({"encoder": 7}, "encoder"),
        ({"temperature": "warm"}, "temperature: expected a number"),
        ({"temperature": True}, "temperature: expected a number"),
        ({"temperature": 0}, "temperature: must be positive"),
        ({"null": 3}, "null: expected the numbers"),
        ({"null": {"temperature": 0.1}}, r"null\.name: expected a number"),
        ({"null": {**CALIBRATION.as_dict()["null"], "said": -1.0}}, "said: must be at least 0"),
        ({"null_described": []}, "null_described: expected the numbers"),
        ({"null_described": {"temperature": 0.1}}, r"null_described\.name: expected a number"),
        ({"sureness_described": 1}, "sureness_described: expected the numbers of a first guess"),
        ({"sureness_described": {"slope": 1}}, r"sureness_described\.shift: expected a number"),
        ({"sureness_described": {"slope": -1, "shift": 0}}, "slope: must be at least 0"),
        ({"unfamiliar": 1}, "unfamiliar: expected the numbers of unfamiliar scenes"),
        ({"unfamiliar": {"middle": 0}}, r"unfamiliar\.temperature: expected a number"),
        (
            {"unfamiliar": {**CALIBRATION.as_dict()["unfamiliar"], "null": 3}},
            r"unfamiliar\.null: expected the numbers of 'none of them'",
        ),
        ({"gate": []}, "gate"),
        ({"gate": {"min_p": 0.5}}, r"gate\.min_margin"),
        ({"gate": {**CALIBRATION.as_dict()["gate"], "min_p": 1.5}}, "min_p"),
        ({"sha256": "abc"}, "sha256"),
    ],
)
def test_a_bad_field_is_named_with_its_file(tmp_path, changes, complaint):
    path = write(tmp_path, {**CALIBRATION.as_dict(), **changes})
    with pytest.raises(ValueError, match=rf"calibration\.json: {complaint}"):
        read_calibration(path)


def test_a_file_that_is_missing_or_no_object_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"nothing\.json: cannot be read"):
        read_calibration(tmp_path / "nothing.json")
    with pytest.raises(ValueError, match=r"calibration\.json: format"):
        read_calibration(write(tmp_path, [1]))
    (tmp_path / "broken.json").write_text("{")
    with pytest.raises(ValueError, match=r"broken\.json: not JSON: Expecting"):
        read_calibration(tmp_path / "broken.json")


def test_the_router_takes_temperature_and_thresholds():
    router = new_router(WordEncoder(), named("scannet200"), RouterParams(), CALIBRATION)
    assert (router.params.judge.gate, router.params.null) == (GATE, NULL)
    assert (router.params.null_described, router.params.sureness_described) == (DESCRIBED, SURENESS)
    assert router.calibration == CALIBRATION.name
    confidence = router.answer(snapshot(), router.read("lamp")).answer.confidence
    assert confidence.temperature == router.labeller.temperature == 0.07
    colder = new_router(WordEncoder(), named("scannet200"), RouterParams())
    usual = colder.answer(snapshot(), colder.read("lamp")).answer.confidence
    assert confidence.p_max / (1 - confidence.p_null) > usual.p_max  # T was 0.1
    assert (usual.p_null, colder.calibration) == (0.0, "none")


def test_another_encoder_is_refused():
    other = Calibration("siglip", 0.07, GATE)
    with pytest.raises(ValueError, match="made for the encoder 'siglip', this one is 'words'"):
        new_router(WordEncoder(), custom(("lamp",)), RouterParams(), other)


def test_the_vectors_stay_those_of_the_encoder():
    tempered = CALIBRATION.of_encoder(WordEncoder())
    plain = WordEncoder().encode_texts(["lamp"])
    assert np.array_equal(tempered.encode_texts(["lamp"]), plain)
    assert (tempered.dim, tempered.ceiling) == (256, 1.0)
