"""Model ids: of the contents of files, not of their places."""

import hashlib
import os
import re

import pytest

from sceneq_nodes import _weights
from sceneq_nodes._weights import digest, model_id, need_package


@pytest.fixture(autouse=True)
def own_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def written(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def test_the_same_contents_in_two_places_are_one_model(tmp_path):
    here, there = (written(tmp_path / place / "w.bin", "weights") for place in ("a", "b"))
    assert model_id("clip", [here]) == model_id("clip", [there])
    assert re.fullmatch(r"clip-[0-9a-f]{10}", model_id("clip", [here]))


@pytest.mark.parametrize("what", ["contents", "name", "settings", "one more"])
def test_anything_else_is_another_model(what, tmp_path):
    files = [written(tmp_path / "a" / "w.bin", "weights")]
    before = model_id("clip", files)
    other = {
        "contents": ("clip", [written(tmp_path / "b" / "w.bin", "weighty")], ""),
        "name": ("siglip", files, ""),
        "settings": ("clip", files, "like openai"),
        "one more": ("clip", [*files, written(tmp_path / "a" / "t.json", "{}")], ""),
    }[what]
    assert model_id(*other) != before


def test_names_of_any_spelling_fit_into_a_key(tmp_path):
    name = model_id("openclip-ViT-B/32 (é)", [written(tmp_path / "w", "")])
    assert re.fullmatch(r"openclip-vit-b-32-[0-9a-f]{10}", name)


def test_a_file_is_hashed_once_and_again_when_it_changes(tmp_path, monkeypatch):
    path = written(tmp_path / "w.bin", "weights")
    assert digest(path) == hashlib.sha256(b"weights").hexdigest()
    monkeypatch.setattr(_weights, "_hash", lambda path: pytest.fail("hashed again"))
    assert digest(path) == hashlib.sha256(b"weights").hexdigest()
    monkeypatch.undo()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path.write_text("WEIGHTS")
    os.utime(path, ns=(1, 1))
    assert digest(path) == hashlib.sha256(b"WEIGHTS").hexdigest()


def test_a_damaged_note_is_made_anew(tmp_path):
    path = written(tmp_path / "w.bin", "weights")
    digest(path)
    (note,) = (tmp_path / "cache" / "sceneq").glob("weights-*.sha256")
    note.write_text("rubbish")
    assert digest(path) == hashlib.sha256(b"weights").hexdigest()


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ValueError, match=re.escape(f"{tmp_path / 'w.bin'}: cannot be read")):
        digest(tmp_path / "w.bin")


def test_an_absent_package_is_named_with_what_to_install():
    wanted = r"^kind: 'sam' needs the package no_such_module.*pip install 'sceneq\[models\]'"
    with pytest.raises(ValueError, match=wanted):
        need_package("no_such_module", "models", "sam")
