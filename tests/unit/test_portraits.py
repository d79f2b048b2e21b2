"""Portraits of single things: who, where, and what comes back from disk."""

import numpy as np
import pytest

from sceneq_tools.errors import UserError
from sceneq_tools.probe_examples import digest, examples
from sceneq_tools.probe_lessons import learn, meanings
from sceneq_tools.room.category import Category
from sceneq_tools.room.mesh import Material
from sceneq_tools.room.models.furniture_catalogue import CatalogueEntry
from sceneq_tools.room.models.solids import assembled, standing_box
from sceneq_tools.room.portrait.album import is_album, keep, pages
from sceneq_tools.room.portrait.photographer import portraits
from sceneq_tools.room.portrait.sitters import Sitter, sitters
from sceneq_tools.room.portrait.stage import stage

from support.questioned import hash_setup

RED = Material(colour=(0.8, 0.1, 0.1))
SIZES = {"sofa": (1.9, 0.8, 0.8), "mug": (0.1, 0.1, 0.1), "lamp": (0.2, 0.2, 0.3)}
CHOSEN = (
    Sitter("sofa", "sofa", 1.0, 0.0),
    Sitter("mug", "coffee mug", 1.0, 0.0),
    Sitter("lamp", "wall lamp", 1.0, 1.6),
)


class Boxes:
    """A library of three boxes and one model without a name."""

    def categories(self):
        return (Category("coffee mug", "top", "", (), (), ("mug",), scale=1.5),)

    def model_ids(self):
        return ("mug", "sofa", "dragon")

    def entry(self, model_id):
        name = {"mug": "Tasse", "sofa": "Couch 2 (grey)"}.get(model_id, "Dragon")
        return CatalogueEntry(model_id, name, "", (1, 1, 1), None, "", elevation_m=0.25)

    def mesh(self, model_id, scale=1.0):
        return assembled([standing_box(RED, SIZES[model_id], (0, 0, 0))])


@pytest.fixture(scope="module")
def taken():
    rng = np.random.default_rng(3)
    room, posed = stage(Boxes(), CHOSEN, 0, rng)
    return room, posed, list(portraits(room, posed, 1, rng))


def test_models_of_rooms_keep_their_names_and_others_get_the_name_people_use():
    found = {one.model_id: one for one in sitters(Boxes())}
    assert found["mug"] == Sitter("mug", "coffee mug", 1.5, 0.25)
    assert found["sofa"] == Sitter("sofa", "sofa", 1.0, 0.25)
    assert "dragon" not in found


def test_things_stand_in_a_row_and_what_hangs_hangs(taken):
    room, posed, _ = taken
    assert [one.sitter.name for one in posed] == ["sofa", "coffee mug", "wall lamp"]
    x = [one.centre[0] for one in posed]
    assert 0 < x[0] < x[1] < x[2] < room.size_m[0]
    assert posed[0].underside_m == pytest.approx(0.0, abs=1e-6)
    assert posed[2].underside_m == pytest.approx(1.6, abs=1e-6)
    assert sum(thing.is_stuff for thing in room.things) == 6


def test_an_album_comes_back_as_it_was_kept(taken, tmp_path):
    _, _, shots = taken
    assert {one.posed.sitter.name for one in shots} >= {"sofa"}
    keep(tmp_path, 0, shots)
    back = list(pages(tmp_path))
    assert is_album(tmp_path)
    assert [one.name for one in back] == [one.posed.sitter.name for one in shots]
    assert [one.model for one in back] == [one.posed.sitter.model_id for one in shots]
    assert all(np.array_equal(a.mask, b.mask) for a, b in zip(back, shots, strict=True))
    assert np.exp(back[0].shape[0]) == pytest.approx(1.9, rel=1e-5)


def test_a_damaged_album_is_named(tmp_path):
    (tmp_path / "portraits-0000.npz").write_bytes(b"no")
    with pytest.raises(UserError, match=r"portraits-0000\.npz: no portraits"):
        list(pages(tmp_path))


def test_lessons_are_learned_from_portraits(taken, tmp_path):
    keep(tmp_path, 0, taken[2])
    found = list(examples(tmp_path, hash_setup(), lambda n=1: None))
    assert [one.thing for one in found] == [one.model for one in found]
    assert {one.model for one in found} >= {"sofa", "lamp"}
    assert {len(one.features) for one in found} == {hash_setup().describe.levels}
    texts = meanings(found)
    lessons = learn(found, texts, lambda said: np.ones((len(said), 384), np.float32), rounds=1)
    assert set(lessons.probe.names) == {one.names[0] for one in found}
    assert len(lessons.text_of) == len(texts)
    assert len(lessons.looks.things) == len({one.model for one in found})
    assert digest(found) == digest(found) != digest(found[:-1])
