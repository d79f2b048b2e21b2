"""`sceneq teach` and `sceneq forget` without a graph: what they ask for and what they print."""

import pytest

from sceneq_tools.answer_text import rows
from sceneq_tools.errors import UserError
from sceneq_tools.names_text import forgotten, listed, taught
from sceneq_tools.teach_command import _request

MUG = {
    "name": "aunt Mary's mug",
    "kind": "individual",
    "by": "anna",
    "when": "2026-11-22 14:05 UTC",
    "state": "attached",
    "id": 7,
    "p": 0.99,
    "centre": [1.0, 2.0, 0.5],
    "inherited": [],
}
LOST = MUG | {"name": "Bertha", "state": "unattached", "id": None, "p": 0.0}
WINDSOR = MUG | {"name": "windsor", "kind": "category", "inherited": [{"id": 9, "p": 0.75}]}
WINDSOR |= {"maybe": [{"id": i, "p": 0.25} for i in range(20, 28)]}


def test_an_instance_or_a_place_in_a_picture_is_named():
    assert _request(["7", "Bertha"], None) == {"id": 7, "name": "Bertha"}
    pointed = _request(["Bertha"], (120, 3.0, 4.5))
    assert pointed == {"name": "Bertha", "view": 120, "x": 3.0, "y": 4.5}


@pytest.mark.parametrize("words", [[], ["7"], ["mug", "Bertha"], ["7", "a", "b"]])
def test_what_to_say_is_said(words):
    with pytest.raises(UserError, match="number of an instance and its name"):
        _request(words, None)
    if len(words) != 1:
        with pytest.raises(UserError, match="say the name, in quotes, and no ID"):
            _request(words, (1, 2.0, 3.0))


def test_what_was_taught_is_told(capsys):
    taught({**WINDSOR, "replaced": [LOST], "pointed_at": [7, 3, 4], "kept": False})
    assert capsys.readouterr().out.splitlines() == [
        "instance 7 is 'windsor' (category, p 0.99)",
        "before, 'Bertha' was unattached, last at 1.00 2.00 0.50 m, "
        "taught by anna on 2026-11-22 14:05 UTC",
        "also there: 3, 4",
        "inherited by 9 (p 0.75)",
        "somewhat alike: " + ", ".join(f"{i} (p 0.25)" for i in range(20, 26)) + ", 2 more",
        "kept in memory only: a graph started with --store DIR remembers names",
    ]


def test_names_are_listed_with_the_lost_ones(capsys):
    listed({"names": [MUG, LOST, WINDSOR], "kept": True, "problem": "1 damaged lines"})
    shown = capsys.readouterr()
    assert "unattached, last at 1.00 2.00 0.50 m" in shown.out
    assert "9 (p 0.75)" in shown.out
    assert shown.err == "the file of names: 1 damaged lines\n"
    listed({"names": [], "kept": True})
    assert capsys.readouterr().out == 'nothing was taught: sceneq teach ID "name" does\n'


def test_what_was_forgotten_is_told(capsys):
    forgotten({"names": [MUG], "kept": True})
    told = capsys.readouterr().out
    assert told == (
        "forgotten: 'aunt Mary's mug' (instance 7), taught by anna on 2026-11-22 14:05 UTC\n"
    )


def test_an_answer_shows_who_a_label_is_from():
    body = {"instances": [{"label": "mug", "label_source": s} for s in ("taught", "encoder", None)]}
    assert [row[1] for row in rows(body)] == ["mug (taught)", "mug", "mug"]
