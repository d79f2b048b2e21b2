"""The routing node with a calibration."""

import json

import pytest

from sceneq_core.routing.gate import GateParams
from sceneq_nodes._backends import BACKENDS
from sceneq_nodes._calibration import Calibration
from sceneq_nodes.routing import Routing
from sceneq_schemas.topics import QUERY_INSTANCES, QUERY_LABELS, QUERY_STATUS

from support.fake_bus import FakeBus


@pytest.fixture(autouse=True)
def _words(monkeypatch, tmp_path):
    kinds = {**BACKENDS["encoder"], "words": "support.furnished:WordEncoder"}
    monkeypatch.setitem(BACKENDS, "encoder", kinds)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def opened(tmp_path, encoder):
    path = tmp_path / "calibration.json"
    path.write_text(json.dumps(Calibration(encoder, 0.05, GateParams(min_p=0.2)).as_dict()))
    params = Routing.Params(
        encoder={"kind": "words"}, labels=("lamp", "chair"), calibration=str(path)
    )
    bus = FakeBus()
    node = Routing(params, bus.context)
    node.open(bus)
    return bus


def test_routing_starts_with_its_encoders_calibration(tmp_path):
    assert opened(tmp_path, "words").query(QUERY_LABELS) is not None


def test_routing_refuses_the_calibration_of_another_encoder(tmp_path):
    with pytest.raises(ValueError, match="made for the encoder 'clip', this one is 'words'"):
        opened(tmp_path, "clip")


def test_answers_and_status_name_the_calibration(tmp_path):
    bus = opened(tmp_path, "words")
    name = Calibration("words", 0.05, GateParams(min_p=0.2)).name
    for topic in (QUERY_STATUS, QUERY_INSTANCES):
        reply = bus.query(topic, **({"q": "lamp"} if topic is QUERY_INSTANCES else {}))
        assert json.loads(reply.payload)["calibration"] == name


def test_routing_without_one_says_so(tmp_path):
    bus = FakeBus()
    node = Routing(Routing.Params(encoder={"kind": "words"}, calibration="none"), bus.context)
    node.open(bus)
    assert json.loads(bus.query(QUERY_STATUS).payload)["calibration"] == "none"
