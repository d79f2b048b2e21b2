"""Choosing models, so that a room shows many of them in many colours."""

from collections import Counter
from dataclasses import dataclass

import numpy as np

from sceneq_tools.room.category import Category
from sceneq_tools.room.layout.probe import bounds
from sceneq_tools.room.library import Library
from sceneq_tools.room.mesh import Mesh

PLAIN_SHARE = 0.3
"""So many of the things that could be painted stay as they are."""

ALIKE_SHARE = 0.75
"""So many of the chairs of a table look like the first one; the others were bought later."""


@dataclass(frozen=True, slots=True, eq=False)
class Item:
    """A model that was chosen: what it is and what it looks like."""

    category: Category
    model_id: str
    mesh: Mesh
    tint: str | None


class Stock:
    """Draws models from a library, those that were not drawn yet first."""

    def __init__(self, library: Library, rng: np.random.Generator) -> None:
        self._library = library
        self._rng = rng
        self._drawn: Counter[tuple[str, str]] = Counter()

    def has(self, name: str) -> bool:
        """Tell whether the library has a label or role."""
        return bool(self._named(name))

    def draw(self, name: str) -> Item | None:
        """Return a model of a label, or of any label of a role; ``None`` when there is none."""
        named = self._named(name)
        if not named:
            return None
        label = self._rarest([category.label for category in named])
        return self.item(next(c for c in named if c.label == label))

    def narrow(self, name: str, width_m: float) -> Item | None:
        """Return the widest model of a label or role that is not wider than this."""
        found: Item | None = None
        for category in self._named(name):
            for model in category.models:
                mesh = self._library.mesh(model, category.scale)
                width = _width(mesh)
                if width <= width_m and (found is None or width > _width(found.mesh)):
                    found = Item(category, model, mesh, None)
        return found

    def item(self, category: Category, tint: str | None = None) -> Item:
        """Return a model of a category, painted at random unless a tint is named."""
        model = self._rarest(list(category.models), category.label)
        self._drawn[("", category.label)] += 1
        self._drawn[(category.label, model)] += 1
        if tint is not None:
            return Item(category, model, self._library.mesh(model, category.scale, tint), tint)
        return self._painted(category, model)

    def again(self, item: Item) -> Item:
        """Return the same model, at times in another colour."""
        if self._rng.random() < ALIKE_SHARE:
            return item
        return self._painted(item.category, item.model_id)

    def _painted(self, category: Category, model: str) -> Item:
        if category.tints and self._rng.random() > PLAIN_SHARE:
            tint = self._rarest(list(category.tints), f"{category.label} tint")
            self._drawn[(f"{category.label} tint", tint)] += 1
            try:
                mesh = self._library.mesh(model, category.scale, tint)
                return Item(category, model, mesh, tint)
            except ValueError:
                # A model without a plain surface keeps its own colours.
                return Item(category, model, self._library.mesh(model, category.scale), None)
        return Item(category, model, self._library.mesh(model, category.scale), None)

    def _named(self, name: str) -> list[Category]:
        categories = self._library.categories()
        labelled = [category for category in categories if category.label == name]
        return labelled or [category for category in categories if category.role == name]

    def _rarest(self, names: list[str], group: str = "") -> str:
        """Return one of those that were drawn least often."""
        least = min(self._drawn[(group, name)] for name in names)
        rare = [name for name in names if self._drawn[(group, name)] == least]
        return rare[int(self._rng.integers(len(rare)))]


def _width(mesh: Mesh) -> float:
    low, high = bounds(mesh)
    return float(high[0] - low[0])
