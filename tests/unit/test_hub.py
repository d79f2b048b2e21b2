"""Where a model lies: in a folder, in the hub's cache, or nowhere to be had."""

import pytest

from sceneq_nodes._hub import model_folder

constants = pytest.importorskip(
    "huggingface_hub.constants", reason="huggingface_hub is not installed"
)
COMMIT = "0123456789abcdef0123456789abcdef01234567"


@pytest.fixture(autouse=True)
def own_cache_without_network(monkeypatch, tmp_path):
    monkeypatch.setattr(constants, "HF_HUB_CACHE", str(tmp_path / "hub"))
    monkeypatch.setattr(constants, "HF_HUB_OFFLINE", True)


def test_a_folder_is_itself(tmp_path):
    assert model_folder(str(tmp_path)) == tmp_path


def test_a_name_is_looked_up_in_the_cache(tmp_path):
    cached = tmp_path / "hub" / "models--org--clip"
    snapshot = cached / "snapshots" / COMMIT
    snapshot.mkdir(parents=True)
    (snapshot / "config.json").write_text("{}")
    (cached / "refs").mkdir()
    (cached / "refs" / "main").write_text(COMMIT)
    assert model_folder("org/clip") == snapshot


def test_what_is_not_cached_and_cannot_be_fetched_is_named():
    with pytest.raises(ValueError, match=r"^model: org/clip is neither a folder nor cached, and"):
        model_folder("org/clip")


@pytest.mark.parametrize("name", ["/no/where", "./here", "~/there/x", "clip", "a/b/c"])
def test_what_is_no_name_of_the_hub_is_no_folder(name):
    with pytest.raises(ValueError, match=r"^model: no folder .* \(a hub repository is named"):
        model_folder(name)
