"""Simple parametric models, so that rooms can be built where no package is installed."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from sceneq_tools.room.category import Category
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.models import shape_furniture as furniture
from sceneq_tools.room.models import shape_seats as seats
from sceneq_tools.room.models import shape_things as things
from sceneq_tools.room.models.finishes import walnut
from sceneq_tools.room.models.solids import Solid, assembled
from sceneq_tools.room.models.tints import tinted

_PREFIX = "shapes#"
Build = Callable[[], list[Solid]]


@dataclass(frozen=True, slots=True)
class _Kind:
    category: Category
    builds: tuple[Build, ...]


class ParametricLibrary:
    """Tables, chairs, mugs and the like, put together from boxes and turned profiles.

    Has a category for every role; needs no files and no attribution.
    """

    name = "shapes"

    def __init__(self) -> None:
        self._builds = {
            model: build
            for kind in _KINDS
            for model, build in zip(kind.category.models, kind.builds, strict=True)
        }
        self._meshes: dict[tuple[str, float, str | None], Mesh] = {}

    def categories(self) -> tuple[Category, ...]:
        """Return every category there are models for, in a fixed order."""
        return tuple(kind.category for kind in _KINDS)

    def mesh(self, model_id: str, scale: float = 1.0, tint: str | None = None) -> Mesh:
        """Return the model in its own frame, its main surface painted when tinted; cached.

        Raises:
            ValueError: no such model or tint; names both.
        """
        key = (model_id, scale, tint)
        if key not in self._meshes:
            self._meshes[key] = self._made(*key)
        return self._meshes[key]

    def attribution(self, model_id: str) -> str:
        """Return ``""``: the shapes are part of this project."""
        return ""

    def _made(self, model_id: str, scale: float, tint: str | None) -> Mesh:
        if model_id not in self._builds:
            raise ValueError(f"no model {model_id!r} in {self.name}")
        if tint is not None:
            try:
                return tinted(self.mesh(model_id, scale), tint)
            except ValueError as error:
                raise ValueError(f"{model_id}: {error}") from error
        if scale != 1.0:
            mesh = self.mesh(model_id)
            return replace(mesh, vertices=mesh.vertices * np.float32(scale))
        return _centred(assembled(self._builds[model_id]()))


def _centred(mesh: Mesh) -> Mesh:
    """Origin at the bottom centre, whatever the parts' own places."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    origin = np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]])
    return replace(mesh, vertices=(mesh.vertices - origin).astype(np.float32))


def _kind(
    label: str,
    role: str,
    material: str,
    good_for: str,
    *builds: Build,
    synonyms: str = "",
    tints: str = "",
    repeats: bool = False,
) -> _Kind:
    """Comma-separated texts keep the table below readable."""
    slug = _PREFIX + label.replace(" ", "-")
    numbers = range(1, len(builds) + 1)
    category = Category(
        label=label,
        role=role,
        material=material,
        affordances=_split(good_for),
        synonyms=_split(synonyms),
        models=tuple(slug if number == 1 else f"{slug}-{number}" for number in numbers),
        tints=_split(tints),
        repeats=repeats,
    )
    return _Kind(category, builds)


def _split(text: str) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",") if word.strip())


_BRIGHT = "red, blue, yellow, green, white"

_KINDS = (
    _kind(
        "sofa",
        "sofa",
        "fabric",
        "sit, lie down",
        seats.sofa,
        lambda: seats.sofa(1.6),
        synonyms="couch",
    ),
    _kind("armchair", "armchair", "fabric", "sit", seats.armchair),
    _kind(
        "office chair", "office_chair", "fabric", "sit", seats.office_chair, synonyms="desk chair"
    ),
    _kind("chair", "chair", "wood", "sit", seats.chair, repeats=True),
    _kind("stool", "stool", "wood", "sit", seats.stool, tints=_BRIGHT),
    _kind("bed", "bed", "fabric", "sleep", seats.bed, lambda: seats.bed(0.9)),
    _kind("coffee table", "coffee_table", "wood", "put things on", furniture.coffee_table),
    _kind(
        "dining table",
        "dining_table",
        "wood",
        "eat at",
        furniture.dining_table,
        lambda: furniture.table(1.1, 0.8, 0.74, walnut()),
    ),
    _kind("desk", "desk", "wood", "work at", furniture.desk),
    _kind(
        "nightstand",
        "nightstand",
        "wood",
        "put things on",
        furniture.nightstand,
        synonyms="bedside table",
    ),
    _kind(
        "tv stand", "tv_stand", "wood", "put things on", furniture.tv_stand, synonyms="TV cabinet"
    ),
    _kind("bookcase", "bookcase", "wood", "store books", furniture.bookcase, synonyms="bookshelf"),
    _kind(
        "chest of drawers",
        "dresser",
        "wood",
        "store clothes",
        furniture.dresser,
        synonyms="dresser",
    ),
    _kind("wardrobe", "wardrobe", "wood", "store clothes", furniture.wardrobe, synonyms="closet"),
    _kind("filing cabinet", "filing_cabinet", "metal", "store documents", furniture.filing_cabinet),
    _kind(
        "kitchen cabinet",
        "kitchen_cabinet",
        "wood",
        "store dishes",
        furniture.kitchen_cabinet,
        furniture.kitchen_drawers,
        repeats=True,
    ),
    _kind(
        "kitchen sink",
        "kitchen_sink",
        "metal",
        "wash dishes",
        furniture.kitchen_sink,
        synonyms="sink",
    ),
    _kind("stove", "stove", "metal", "cook", furniture.stove),
    _kind(
        "refrigerator",
        "refrigerator",
        "metal",
        "keep food cold",
        furniture.refrigerator,
        synonyms="fridge",
    ),
    _kind("washing machine", "washing_machine", "metal", "wash clothes", furniture.washing_machine),
    _kind("upper cabinet", "upper_cabinet", "wood", "store dishes", furniture.upper_cabinet),
    _kind("range hood", "range_hood", "metal", "ventilate", furniture.range_hood),
    _kind(
        "television", "television", "plastic", "watch movies", furniture.television, synonyms="TV"
    ),
    _kind(
        "rug",
        "rug",
        "fabric",
        "",
        furniture.rug,
        lambda: furniture.rug((1.8, 1.2), "stripes", 12),
        synonyms="carpet",
    ),
    _kind("floor lamp", "floor_lamp", "metal", "light the room", seats.floor_lamp),
    _kind(
        "potted plant", "plant", "plant", "", furniture.potted_plant, synonyms="plant, houseplant"
    ),
    _kind(
        "coffee mug",
        "top",
        "ceramic",
        "drink from",
        things.mug,
        synonyms="mug",
        tints=_BRIGHT,
        repeats=True,
    ),
    _kind(
        "plastic cup",
        "top",
        "plastic",
        "drink from",
        things.plastic_cup,
        tints="blue, red, green",
        repeats=True,
    ),
    _kind("bowl", "top", "ceramic", "hold food", things.bowl, tints=_BRIGHT, repeats=True),
    _kind(
        "plate",
        "top",
        "ceramic",
        "hold food",
        things.plate,
        tints="white, blue, yellow",
        repeats=True,
    ),
    _kind(
        "wine bottle",
        "top",
        "glass",
        "pour wine",
        things.bottle,
        synonyms="bottle of wine",
        repeats=True,
    ),
    _kind("vase", "top", "ceramic", "hold flowers", things.vase, tints=_BRIGHT),
    _kind("kettle", "top", "metal", "boil water", things.kettle),
    _kind("cooking pot", "top", "metal", "cook", things.cooking_pot, synonyms="pot"),
    _kind("apple", "top", "food", "eat", things.apple, tints="red, green, yellow", repeats=True),
    _kind("book", "top", "paper", "read", things.book, tints=_BRIGHT, repeats=True),
    _kind(
        "laptop",
        "top",
        "plastic",
        "browse the internet",
        things.laptop,
        synonyms="notebook computer",
    ),
    _kind("microwave", "top", "metal", "heat up food", things.microwave, synonyms="microwave oven"),
    _kind("toaster", "top", "metal", "toast bread", things.toaster),
    _kind("speaker", "top", "wood", "listen to music", things.speaker, synonyms="loudspeaker"),
    _kind("alarm clock", "top", "plastic", "check the time", things.clock),
    _kind("table lamp", "top", "fabric", "read in the dark", furniture.table_lamp, synonyms="lamp"),
    _kind("picture frame", "top", "wood", "", things.picture_frame, synonyms="photo frame"),
    _kind("candle", "top", "wax", "light the room", things.candle),
    _kind("gift box", "top", "paper", "", things.gift_box, synonyms="present, gift", tints=_BRIGHT),
    _kind(
        "cardboard box", "floor", "cardboard", "store things", things.cardboard_box, synonyms="box"
    ),
    _kind(
        "suitcase",
        "floor",
        "plastic",
        "pack clothes for a trip",
        things.suitcase,
        tints="blue, red, gray",
    ),
    _kind(
        "trash can",
        "floor",
        "metal",
        "throw away trash",
        things.trash_can,
        synonyms="trash bin, dustbin",
    ),
    _kind("basketball", "floor", "rubber", "play", things.basketball),
    _kind("fire extinguisher", "floor_wall", "metal", "put out a fire", things.fire_extinguisher),
    _kind("wall clock", "wall", "wood", "check the time", things.wall_clock),
)
