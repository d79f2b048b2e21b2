"""Who is portrayed: every household model of the furniture package, and its name."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import resources

import yaml

from sceneq_tools.room.models.sweet_home import SweetHomeLibrary

_NOISE = re.compile(r"\(.*?\)|\d+")


@dataclass(frozen=True, slots=True)
class Sitter:
    """A model that is called ``name``; ``scale`` mends its size, ``elevation_m`` is where it hangs
    above the floor, 0 for what stands."""

    model_id: str
    name: str
    scale: float
    elevation_m: float


def sitters(library: SweetHomeLibrary) -> tuple[Sitter, ...]:
    """Return the models that have a name, in the library's order.

    Those that rooms are furnished with are called as there.
    """
    return tuple(_named(library, _other_names()))


def _named(library: SweetHomeLibrary, others: dict[str, str]) -> Iterator[Sitter]:
    curated = {m: category for category in library.categories() for m in category.models}
    for model_id in library.model_ids():
        entry = library.entry(model_id)
        if model_id in curated:
            category = curated[model_id]
            yield Sitter(model_id, category.label, category.scale, entry.elevation_m)
        elif (name := others.get(_NOISE.sub("", entry.name).strip().lower())) is not None:
            yield Sitter(model_id, name, 1.0, entry.elevation_m)


def _other_names() -> dict[str, str]:
    """Return name in the catalogue -> name people use."""
    table = resources.files("sceneq_tools.room.portrait").joinpath("names.yaml")
    names: dict[str, list[str]] = yaml.safe_load(table.read_text("utf-8"))
    return {said: name for name, catalogued in names.items() for said in catalogued}
