"""The household models of Debian's package ``sweethome3d-furniture``."""

import posixpath
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sceneq_tools.room.category import Category
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.models.archive import Archive
from sceneq_tools.room.models.curated import curated_categories
from sceneq_tools.room.models.furniture_catalogue import CatalogueEntry
from sceneq_tools.room.models.model_mesh import model_mesh, surface
from sceneq_tools.room.models.mtl_file import ObjMaterial
from sceneq_tools.room.models.tints import tinted

_DEFAULT_MATERIAL = ObjMaterial()


@dataclass(frozen=True, slots=True, eq=False)
class _Source:
    """Where a model is found and whom to thank for it."""

    archive: Archive
    entry: CatalogueEntry
    library: str
    licence: str


class SweetHomeLibrary:
    """Models of all ``.sh3f`` archives of a folder that the table of categories names.

    Args:
        folder: with at least one archive.
        categories: the table; those models of it that no archive has are left out, and categories
            without models with them.

    Raises:
        ValueError: an archive or its catalogue cannot be read, or none of the models is there.
    """

    name = "sweethome3d-furniture"

    def __init__(self, folder: Path, categories: tuple[Category, ...] | None = None) -> None:
        self._sources = _sources(folder)
        table = curated_categories() if categories is None else categories
        self._categories = tuple(c for c in map(self._available, table) if c.models)
        if not self._categories:
            raise ValueError(f"{folder}: none of the models of the table of categories is there")
        self._meshes: dict[tuple[str, float, str | None], Mesh] = {}

    def categories(self) -> tuple[Category, ...]:
        """Return the categories that have a model here, in the table's order."""
        return self._categories

    def model_ids(self) -> tuple[str, ...]:
        """Return all models, those without a category too."""
        return tuple(self._sources)

    def mesh(self, model_id: str, scale: float = 1.0, tint: str | None = None) -> Mesh:
        """Return the model in its own frame, its main surface painted when tinted; cached.

        Raises:
            ValueError: no such model or tint, or a file that cannot be read; names both.
        """
        key = (model_id, scale, tint)
        if key not in self._meshes:
            self._meshes[key] = self._made(*key)
        return self._meshes[key]

    def entry(self, model_id: str) -> CatalogueEntry:
        """Return what the catalogue says of a model; raise ``ValueError`` when there is none."""
        return self._source(model_id).entry

    def forget_meshes(self) -> None:
        """Free the memory of the meshes that were read."""
        self._meshes.clear()

    def attribution(self, model_id: str) -> str:
        """Return name, author, library and licence in one line."""
        source = self._source(model_id)
        parts = (source.entry.name, source.entry.creator, source.library, source.licence)
        return " | ".join(part for part in parts if part)

    def _made(self, model_id: str, scale: float, tint: str | None) -> Mesh:
        if tint is not None:
            try:
                return tinted(self.mesh(model_id, scale), tint)
            except ValueError as error:
                raise ValueError(f"{model_id}: {error}") from error
        if scale != 1.0:
            mesh = self.mesh(model_id)
            return replace(mesh, vertices=mesh.vertices * np.float32(scale))
        return self._read(self._source(model_id))

    def _read(self, source: _Source) -> Mesh:
        obj, materials = source.archive.model(source.entry.model)
        folder = posixpath.dirname(source.entry.model)
        looks = []
        for name in obj.material_names:
            material = materials.get(name, _DEFAULT_MATERIAL)
            written = material.picture
            picture = None if written is None else source.archive.picture(folder, written)
            looks.append(surface(material, picture))
        try:
            return model_mesh(source.entry, obj, tuple(looks))
        except ValueError as error:
            place = f"{source.archive.path.name}: {source.entry.model}"
            raise ValueError(f"{place}: {error}") from error

    def _source(self, model_id: str) -> _Source:
        if model_id not in self._sources:
            raise ValueError(f"no model {model_id!r} in {self.name}")
        return self._sources[model_id]

    def _available(self, category: Category) -> Category:
        return replace(category, models=tuple(m for m in category.models if m in self._sources))


def _sources(folder: Path) -> dict[str, _Source]:
    """All models by id; an id that another archive has already gets its archive's name in front."""
    sources: dict[str, _Source] = {}
    for path in sorted(folder.glob("*.sh3f")):
        archive = Archive(path)
        catalogue = archive.catalogue()
        for entry in catalogue.entries:
            model_id = entry.id if entry.id not in sources else f"{path.name}:{entry.id}"
            sources[model_id] = _Source(archive, entry, catalogue.name, catalogue.licence)
    return sources
