"""Glosses of nouns in the files of WordNet."""

import pytest

from sceneq_tools.wordnet import WordNet

BAT = "00000000 05 n 01 bat 0 000 | nocturnal mammal\n"
CLUB = '00000040 06 n 01 bat 0 000 | a club used for hitting; "he swung it"\n'


@pytest.fixture
def dictionary(tmp_path):
    (tmp_path / "data.noun").write_text(BAT + CLUB)
    index = f"  1 licence\nbat n 2 0 2 0 00000000 {len(BAT):08d}\n"
    (tmp_path / "index.noun").write_text(index)
    return WordNet(tmp_path)


def test_a_thing_is_meant_not_an_animal(dictionary):
    assert dictionary.gloss("Bat") == "a club used for hitting"


def test_an_unknown_word_has_no_gloss(dictionary):
    assert dictionary.gloss("unicorn horn") is None


def test_no_dictionary(tmp_path):
    with pytest.raises(OSError, match=r"data\.noun"):
        WordNet(tmp_path / "gone")
