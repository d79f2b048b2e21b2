"""Chance for surfaces: what is learned from a thing should be its form, not its colour."""

from dataclasses import replace

import cv2
import numpy as np

from sceneq_tools.room.layout.structure import PAINTS, PILES, STONES, WOODS
from sceneq_tools.room.mesh import Colour, Material, Mesh
from sceneq_tools.room.textures import textures

FLAT, PAINTED = 0.35, 0.45
"""So many things lose their pictures to the mean colour, and get other colours."""


def any_colour(rng: np.random.Generator) -> Colour:
    """Return a grey, or as often any hue."""
    if rng.random() < 0.5:
        level = rng.uniform(0.05, 0.95)
        grey = np.clip(level + rng.normal(0, 0.02, 3), 0.02, 1)
        return (float(grey[0]), float(grey[1]), float(grey[2]))
    hsv = rng.random() * 180, rng.uniform(0.2, 1) * 255, rng.uniform(0.2, 1) * 255
    red, green, blue = cv2.cvtColor(np.array([[hsv]], np.uint8), cv2.COLOR_HSV2RGB)[0, 0] / 255.0
    return (float(red), float(green), float(blue))


def repainted(mesh: Mesh, rng: np.random.Generator) -> Mesh:
    """Return the mesh with surfaces as they are, flattened or painted."""
    flat, paint = rng.random() < FLAT, rng.random() < PAINTED
    new: dict[Colour, Colour] = {}
    materials = []
    for material in mesh.materials:
        if flat and material.texture is not None:
            material = _flattened(material)
        materials.append(_painted(material, rng, new) if paint else material)
    return replace(mesh, materials=tuple(materials))


def floor_and_wall(rng: np.random.Generator) -> tuple[Material, Material]:
    """Return materials of a floor and of walls."""
    floor = _floor(rng, int(rng.integers(4)))
    if rng.random() < 0.7:
        return floor, Material(colour=PAINTS[rng.integers(len(PAINTS))])
    if rng.random() < 0.6:
        return floor, Material(colour=any_colour(rng))
    return floor, _pictured(textures.wallpaper(rng))


def furniture_top(rng: np.random.Generator) -> Material:
    """Return a material for what small things stand on."""
    if rng.random() < 0.5:
        return Material(colour=any_colour(rng))
    return _pictured(textures.wood(rng, WOODS[rng.integers(len(WOODS))]))


def _floor(rng: np.random.Generator, kind: int) -> Material:
    if kind == 0:
        wood = WOODS[rng.integers(len(WOODS))]
        return _pictured(textures.planks(rng, wood, size_px=512))
    if kind == 1:
        return _pictured(textures.tiles(rng, STONES[rng.integers(len(STONES))]))
    if kind == 2:
        return _pictured(textures.carpet(rng, PILES[rng.integers(len(PILES))]))
    return Material(colour=any_colour(rng))


def _pictured(texture: np.ndarray) -> Material:
    return Material(texture=texture, colour=(1, 1, 1))


def _flattened(material: Material) -> Material:
    """Return the mean colour of a picture; what is cut out of it stays a picture."""
    assert material.texture is not None
    texels = material.texture.reshape(-1, 4)
    cover = texels[:, 3:] / 255.0
    if cover.mean() <= 0.98:
        return material
    mean = (texels[:, :3] * cover).sum(axis=0) / max(cover.sum(), 1) / 255.0
    red, green, blue = np.clip(mean * np.array(material.colour), 0, 1).tolist()
    return replace(material, texture=None, colour=(red, green, blue))


def _painted(material: Material, rng: np.random.Generator, new: dict[Colour, Colour]) -> Material:
    """Return it in another colour; surfaces of one colour stay of one colour."""
    if material.texture is not None:
        tinted = rng.random() < 0.5
        return replace(material, colour=any_colour(rng)) if tinted else material
    if material.opacity < 0.5 or material.emission > 0:
        return material
    red, green, blue = np.round(material.colour, 2).tolist()
    drawn = any_colour(rng) if rng.random() < 0.8 else material.colour
    return replace(material, colour=new.setdefault((red, green, blue), drawn))
