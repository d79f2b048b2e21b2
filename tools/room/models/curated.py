"""The table of models that are worth using, and what they are called (``categories.yaml``)."""

from dataclasses import fields
from importlib import resources
from typing import Any

import yaml

from sceneq_tools.room.category import Category
from sceneq_tools.room.models.tints import TINTS

ROLES = (
    *("sofa", "armchair", "office_chair", "chair", "stool", "bed"),
    *("coffee_table", "dining_table", "desk", "nightstand", "tv_stand"),
    *("bookcase", "dresser", "wardrobe", "filing_cabinet"),
    *("kitchen_cabinet", "kitchen_sink", "stove", "refrigerator", "washing_machine"),
    *("upper_cabinet", "range_hood"),
    *("television", "rug", "floor_lamp", "plant"),
    *("top", "floor", "floor_wall", "wall"),
)
"""Where things go; see ``sceneq_tools.room.category``."""

_KEYS = {field.name for field in fields(Category)} - {"label"}
_LISTS = ("affordances", "synonyms", "models", "tints")


def curated_categories() -> tuple[Category, ...]:
    """Return the shipped table, in its order."""
    table = resources.files("sceneq_tools.room.models").joinpath("categories.yaml")
    return parse_categories(table.read_text("utf-8"))


def parse_categories(text: str) -> tuple[Category, ...]:
    """Read a table of categories: a mapping from label to what is known of it.

    Raises:
        ValueError: an unknown key, role or tint, a label or synonym given twice, or no models; the
            message names the label.
    """
    table = yaml.safe_load(text)
    if not isinstance(table, dict):
        raise ValueError("categories: expected a mapping from label to its properties")
    categories = tuple(_category(str(label), row) for label, row in table.items())
    _check_names(categories)
    return categories


def _category(label: str, row: Any) -> Category:
    if not isinstance(row, dict):
        raise ValueError(f"category {label!r}: expected a mapping, got {row!r}")
    unknown = sorted(set(row) - _KEYS)
    if unknown:
        raise ValueError(f"category {label!r}: unknown key {unknown[0]!r}")
    lists = {key: _words(label, key, row.get(key, [])) for key in _LISTS}
    category = Category(
        label=label,
        role=str(row.get("role", "")),
        material=str(row.get("material", "")),
        repeats=bool(row.get("repeats", False)),
        scale=float(row.get("scale", 1.0)),
        **lists,
    )
    _check(category)
    return category


def _words(label: str, key: str, value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(isinstance(word, str) for word in value):
        raise ValueError(f"category {label!r}: {key} should be a list of texts, got {value!r}")
    return tuple(value)


def _check(category: Category) -> None:
    where = f"category {category.label!r}"
    if category.role not in ROLES:
        raise ValueError(f"{where}: unknown role {category.role!r}")
    if not category.models:
        raise ValueError(f"{where}: no models")
    if category.scale <= 0:
        raise ValueError(f"{where}: scale should be greater than zero, got {category.scale}")
    for tint in category.tints:
        if tint not in TINTS:
            raise ValueError(f"{where}: unknown tint {tint!r}")


def _check_names(categories: tuple[Category, ...]) -> None:
    owner: dict[str, str] = {}
    for category in categories:
        for name in (category.label, *category.synonyms):
            if owner.setdefault(name.lower(), category.label) != category.label:
                raise ValueError(
                    f"category {category.label!r}: the name {name!r} belongs to "
                    f"{owner[name.lower()]!r} already"
                )
