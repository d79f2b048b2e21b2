"""Scenes described by who was not taught with their furniture, and what is fitted on them."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import yaml

from sceneq_core.routing.scene import SceneSnapshot
from sceneq_nodes._probe_file import HOUSEHOLD, read_probe, write_probe
from sceneq_tools.errors import UserError
from sceneq_tools.evaluation import calibration_fit
from sceneq_tools.evaluation.absent_names import absent_names
from sceneq_tools.evaluation.calibration import Scene
from sceneq_tools.evaluation.calibration_fit import QUESTIONS, Examples, fit
from sceneq_tools.evaluation.retrieval_candidates import Candidates
from sceneq_tools.evaluation.retrieval_queries import Query, Questioned
from sceneq_tools.evaluation.strangers import (
    closest_things,
    estranged,
    models_of,
    open_strangers,
    strange_scenes,
)
from sceneq_tools.evaluation.true_things import TrueThing

from support.furnished import ROOM, WordEncoder, descriptors, furnish, ids, router
from support.questioned import hash_setup

NO_IDS = np.zeros(0, np.int32)


def seen(noise: float, familiarity: float, seed: int = 7) -> SceneSnapshot:
    scene, rows = furnish(noise=noise), descriptors(ROOM, noise, seed)
    scene.apply_descriptors(5, rows, NO_IDS, dict.fromkeys(rows, familiarity))
    return scene.snapshot()


def candidates(snapshot: SceneSnapshot) -> Candidates:
    there = {one.instance_id: frozenset([one.instance_id]) for one in snapshot.instances}
    return Candidates("true instances", snapshot, {"exact": there})


KNOWN = candidates(seen(0.6, 0.9))
STRANGE = candidates(seen(4.0, 0.5, seed=8))
THINGS = tuple(
    TrueThing(number, f"thing {number}", (thing.name.split()[-1], thing.name), False, 0)
    for number, thing in enumerate(ROOM, 1)
)
QUERIES = (
    *(
        Query(name, "category", frozenset(ids(name)))
        for name in sorted({thing.name for thing in ROOM})
    ),
    Query("aquarium", "absent", frozenset()),
)


@pytest.fixture
def _own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture(autouse=True)
def _few_absent_names(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(calibration_fit, "absent_names", partial(absent_names, many=6))


def room(of: Candidates, folder: Path = Path("room")) -> Scene:
    return Scene(Questioned(folder, THINGS, QUERIES, "f" * 64), of)


def setup():
    return replace(hash_setup(), encoder=WordEncoder(), router=router())


def test_each_is_described_by_who_was_not_taught_with_its_model():
    models = {1: "Sofa#1", 2: "Chair#2", 3: "Lamp#3"}
    other = candidates(seen(2.5, 0.4, seed=9))
    parts = [(frozenset(["Sofa#1"]), STRANGE), (frozenset(["Chair#2"]), other)]
    made = estranged(KNOWN, parts, models).snapshot
    rows = [STRANGE.snapshot, other.snapshot, *[KNOWN.snapshot] * 14]
    for row, source in enumerate(rows):
        assert np.array_equal(made.descriptors[row], source.descriptors[row])
        assert np.array_equal(made.label_scores[row], source.label_scores[row])
        assert made.instances[row] is source.instances[row]
        for name in ("label_mean", "colour_scores"):
            column, theirs = getattr(made.columns, name), getattr(source.columns, name)
            assert np.array_equal(column[row], theirs[row])
    assert made.columns.familiarity == pytest.approx([0.5, 0.4, *[-1.0] * 14])
    assert np.array_equal(made.columns.aabb_world, KNOWN.snapshot.columns.aabb_world)


def test_other_instances_are_not_mixed():
    fewer = furnish(ROOM[:-1]).snapshot()
    with pytest.raises(UserError, match="strangers: other instances"):
        estranged(KNOWN, [(frozenset("a"), candidates(fewer))], {})


def test_an_instance_shows_what_it_overlaps_most():
    rules = {
        "IoU >= 0.1": {1: frozenset([7, 8]), 2: frozenset([8])},
        "IoU >= 0.5": {1: frozenset([8]), 3: frozenset()},
    }
    assert closest_things(replace(KNOWN, matches=rules)) == {7: 1, 8: 1}


def test_models_are_read_beside_the_truth(tmp_path):
    records = [{"id": 1, "model": "Sofa#1"}, {"id": 2}, {"id": 3, "model": ""}]
    (tmp_path / "instances.json").write_text(json.dumps({"instances": records}))
    assert models_of(tmp_path) == {1: "Sofa#1"}
    probe = type("Who", (), {"withheld": frozenset(["Sofa#1"])})()
    made = strange_scenes([room(KNOWN, tmp_path)], [(probe, [room(STRANGE, tmp_path)])])[0]
    assert made.candidates.snapshot.columns.familiarity[:2] == pytest.approx([0.5, -1.0])


@pytest.mark.usefixtures("_own_cache")
def test_strangers_add_to_a_calibration_and_change_nothing_else_in_it():
    strange = Examples((room(STRANGE),))
    alone = fit([room(KNOWN)], setup(), QUESTIONS)
    both = fit([room(KNOWN)], setup(), QUESTIONS, (), strange)
    one, other = alone.calibration, both.calibration
    assert (one.unfamiliar, alone.strange) == (None, None)
    assert (one.temperature, one.null) == (other.temperature, other.null)
    assert (other.unfamiliar.middle, both.strange.recordings) == (pytest.approx(0.7), ("room",))
    assert other.unfamiliar.null != one.null
    json.dumps(both.as_dict())


def test_a_probe_that_was_taught_with_everything_is_no_stranger(tmp_path):
    strangers = tmp_path / "strangers"
    strangers.mkdir()
    with pytest.raises(UserError, match=r"strangers: no \.npz file in it \(make it with"):
        open_strangers(strangers, None, tmp_path)
    (strangers / "all.npz").write_bytes(HOUSEHOLD.read_bytes())
    with pytest.raises(UserError, match=r"all\.npz: it was taught with everything \(make it with"):
        open_strangers(strangers, None, tmp_path)
    (strangers / "all.npz").write_bytes(b"no probe")
    with pytest.raises(UserError, match=r"all\.npz: no probe file"):
        open_strangers(strangers, None, tmp_path)


def test_a_stranger_has_the_graph_with_its_probe_in_both_nodes_that_speak(tmp_path):
    strangers = tmp_path / "strangers"
    strangers.mkdir()
    whole = read_probe(HOUSEHOLD)
    texts = [f"text {n}" for n in range(len(whole.lessons.text_vectors))]
    probe = strangers / "some.npz"
    write_probe(probe, whole.lessons, texts, "0" * 16, ["Sofa#1"])
    graph = tmp_path / "graph.yaml"
    of_graph = (
        {"id": "segmentation", "params": {"segmenter": {"kind": "rgbd"}}},
        {"id": "encoding", "params": {"describe": {"levels": 2}}},
        {"id": "asker", "kind": "routing", "params": {"labels": ["sofa"], "calibration": "a.json"}},
    )
    graph.write_text(yaml.safe_dump({"nodes": list(of_graph)}))
    (one,) = open_strangers(strangers, graph, tmp_path)
    assert one.withheld == {"Sofa#1"}
    segmentation, encoding, asker = yaml.safe_load(one.graph.read_text())["nodes"]
    encoder = {"kind": "conse", "probe": str(probe)}
    assert segmentation == of_graph[0]
    assert encoding["params"] == {"describe": {"levels": 2}, "encoder": encoder}
    assert asker["params"] == {"labels": ["sofa"], "encoder": encoder}
    assert one.setup.describe.levels == 2
    assert one.setup.encoder.dim == len(whole.lessons.probe) + 1012
    assert one.setup.calibration is None
