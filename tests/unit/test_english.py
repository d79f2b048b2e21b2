"""Small pieces of English."""

import pytest

from sceneq_core.reasoning.english import counted, listed, metres, ordinal, plural, singular


@pytest.mark.parametrize(
    ("one", "many"),
    [
        ("cup", "cups"),
        ("coffee table", "coffee tables"),
        ("box", "boxes"),
        ("couch", "couches"),
        ("glass", "glasses"),
        ("baby", "babies"),
        ("toy", "toys"),
        ("knife", "knives"),
        ("bookshelf", "bookshelves"),
        ("vase", "vases"),
        ("house", "houses"),
        ("cactus", "cactuses"),
    ],
)
def test_plurals(one, many):
    assert plural(one) == many


@pytest.mark.parametrize(
    ("many", "one"),
    [
        ("cups", "cup"),
        ("boxes", "box"),
        ("couches", "couch"),
        ("babies", "baby"),
        ("knives", "knife"),
        ("vases", "vase"),
        ("houses", "house"),
        ("people", "person"),
        ("red chairs", "red chair"),
        ("cactus", "cactus"),
        ("glass", "glass"),
        ("stairs", "stairs"),
        ("tv", "tv"),
        ("", ""),
    ],
)
def test_singulars(many, one):
    assert singular(many) == one


def test_counting_listing_and_measuring():
    assert [counted(n, "mug") for n in (0, 1, 2)] == ["no mug", "1 mug", "2 mugs"]
    assert [listed(["a", "b", "c"][:n]) for n in range(4)] == ["", "a", "a and b", "a, b and c"]
    assert [metres(x) for x in (0.214, 1.44)] == ["0.21 m", "1.4 m"]
    ranks = [ordinal(n) for n in (1, 2, 3, 4, 11, 12, 21)]
    assert ranks == ["1st", "2nd", "3rd", "4th", "11th", "12th", "21st"]
