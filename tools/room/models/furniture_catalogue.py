"""The table of contents of a Sweet Home 3D library, a Java properties file in its archive."""

import re
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64

CATALOGUE_FILE = "PluginFurnitureCatalog.properties"

_ENTRY = re.compile(r"(\w+)#(\d+)$")
_ESCAPE = re.compile(r"\\u([0-9a-fA-F]{4})|\\(.)")
_CM = 0.01


@dataclass(frozen=True, slots=True, eq=False)
class CatalogueEntry:
    """One model of a library.

    Attributes:
        id: stable name, ``Scopia#armchair``.
        name: English name in the catalogue.
        model: path of the OBJ file in the archive.
        size_m: width (x), height (y) and depth (z) of the model as it should appear.
        rotation: (3, 3) to be applied to the OBJ file's points first, or ``None``.
        creator: who made it.
        elevation_m: how high above the floor it usually hangs; 0 for what stands.
    """

    id: str
    name: str
    model: str
    size_m: tuple[float, float, float]
    rotation: Float64 | None
    creator: str
    elevation_m: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Catalogue:
    """A library's name, licence and entries."""

    name: str
    licence: str
    entries: tuple[CatalogueEntry, ...]


def parse_catalogue(text: str) -> Catalogue:
    """Read the properties file's text.

    Raises:
        ValueError: an entry without model or size, or a bad number; names entry number and key.
    """
    head: dict[str, str] = {}
    numbered: dict[int, dict[str, str]] = {}
    for key, value in _properties(text):
        match = _ENTRY.match(key)
        if match:
            numbered.setdefault(int(match[2]), {})[match[1]] = value
        else:
            head[key] = value
    entries = tuple(_entry(number, numbered[number]) for number in sorted(numbered))
    return Catalogue(head.get("name", ""), head.get("license", ""), entries)


def _properties(text: str) -> list[tuple[str, str]]:
    pairs = []
    for line in text.splitlines():
        key, equals, value = line.strip().partition("=")
        if equals and not key.startswith(("#", "!")):
            pairs.append((key.strip(), _unescaped(value.strip())))
    return pairs


def _unescaped(value: str) -> str:
    return _ESCAPE.sub(lambda match: chr(int(match[1], 16)) if match[1] else match[2], value)


def _entry(number: int, values: dict[str, str]) -> CatalogueEntry:
    for key in ("model", "width", "height", "depth"):
        if key not in values:
            raise ValueError(f"entry {number} has no {key}#{number}")
    name = values.get("name", "")
    return CatalogueEntry(
        id=values.get("id", f"{name}#{number}"),
        name=name,
        model=values["model"].lstrip("/"),
        size_m=(
            _size(values, "width", number),
            _size(values, "height", number),
            _size(values, "depth", number),
        ),
        rotation=_rotation(values["modelRotation"], number) if "modelRotation" in values else None,
        creator=values.get("creator", ""),
        elevation_m=_numbers(values.get("elevation", "0"), 1, f"elevation#{number}")[0] / 100,
    )


def _size(values: dict[str, str], key: str, number: int) -> float:
    size = _numbers(values[key], 1, f"{key}#{number}")[0] * _CM
    if size <= 0:
        raise ValueError(f"{key}#{number} must be greater than zero, got {values[key]}")
    return size


def _rotation(value: str, number: int) -> Float64:
    return np.array(_numbers(value, 9, f"modelRotation#{number}")).reshape(3, 3)


def _numbers(value: str, count: int, key: str) -> list[float]:
    try:
        numbers = [float(word) for word in value.split()]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise ValueError(f"{key} should be {count} number(s), got {value!r}")
    return numbers
