"""The table of categories."""

import pytest

from sceneq_tools.room.models.curated import ROLES, curated_categories, parse_categories

ROW = "mug: {role: top, models: [a]}\n"


def test_the_shipped_table_is_sound_and_rich():
    table = curated_categories()
    assert len(table) >= 110
    assert {category.role for category in table} == set(ROLES)
    assert sum(len(category.models) for category in table) >= 250
    models = [model for category in table for model in category.models]
    assert len(models) == len(set(models)), "no model has two names"


def test_a_row_becomes_a_category():
    (mug,) = parse_categories(
        "mug: {role: top, material: clay, models: [a, b], tints: [red], repeats: true, scale: 2}"
    )
    assert (mug.label, mug.role, mug.material) == ("mug", "top", "clay")
    assert (mug.models, mug.tints, mug.repeats, mug.scale) == (("a", "b"), ("red",), True, 2.0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[1]", "expected a mapping from label"),
        ("mug: 3", "category 'mug': expected a mapping"),
        ("mug: {role: sky, models: [a]}", "category 'mug': unknown role 'sky'"),
        ("mug: {role: top}", "category 'mug': no models"),
        ("mug: {role: top, models: a}", "category 'mug': models should be a list of texts"),
        ("mug: {role: top, models: [a], tints: [mauve]}", "category 'mug': unknown tint 'mauve'"),
        ("mug: {role: top, models: [a], size: 3}", "category 'mug': unknown key 'size'"),
        ("mug: {role: top, models: [a], scale: 0}", "scale should be greater than zero"),
        (ROW + "cup: {role: top, models: [b], synonyms: [Mug]}", "the name 'Mug' belongs to 'mug'"),
    ],
)
def test_mistakes_are_named(text, message):
    with pytest.raises(ValueError, match=message):
        parse_categories(text)
