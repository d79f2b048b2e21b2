"""Wavefront MTL text: named materials, before their pictures are read."""

from dataclasses import dataclass, replace

from sceneq_tools.room.mesh import Colour


@dataclass(frozen=True, slots=True)
class ObjMaterial:
    """One ``newmtl``.

    Attributes:
        colour: ``Kd`` as written (sRGB, as the authors saw it).
        specular: mean of ``Ks``; ``exponent``: ``Ns``.
        opacity: ``d``, or 1 - ``Tr``.
        picture: path of ``map_Kd`` as written, or ``None``.
    """

    colour: Colour = (0.8, 0.8, 0.8)
    specular: float = 0.0
    exponent: float = 10.0
    opacity: float = 1.0
    picture: str | None = None


def parse_mtl(text: str) -> dict[str, ObjMaterial]:
    """Read an MTL file's text; unknown statements are passed over.

    Raises:
        ValueError: a number that is none, or too few; the message starts with ``line N:``.
    """
    materials: dict[str, ObjMaterial] = {}
    name: str | None = None
    for number, line in enumerate(text.splitlines(), 1):
        keyword, rest = [*line.split(None, 1), "", ""][:2]
        if keyword == "newmtl":
            name = rest.strip()
            materials[name] = ObjMaterial()
        elif name is not None:
            try:
                materials[name] = _with(materials[name], keyword, rest.strip())
            except ValueError:
                raise ValueError(f"line {number}: bad value in {line.strip()!r}") from None
    return materials


def _with(material: ObjMaterial, keyword: str, value: str) -> ObjMaterial:
    match keyword:
        case "Kd":
            return replace(material, colour=_colour(value))
        case "Ks":
            return replace(material, specular=sum(_colour(value)) / 3)
        case "Ns":
            return replace(material, exponent=float(value.split()[0]))
        case "d":
            return replace(material, opacity=_clipped(value.split()[-1]))
        case "Tr":
            return replace(material, opacity=1.0 - _clipped(value.split()[-1]))
        case "map_Kd":
            return replace(material, picture=_path(value))
    return material


def _colour(value: str) -> Colour:
    red, green, blue = (_clipped(word) for word in value.split()[:3])
    return red, green, blue


def _clipped(word: str) -> float:
    return min(max(float(word), 0.0), 1.0)


def _path(value: str) -> str | None:
    """Without the options in front (``-s 1 1 1 wood.jpg``); names may hold blanks."""
    if value.startswith("-"):
        value = value.split()[-1]
    return value.replace("\\", "/") or None
