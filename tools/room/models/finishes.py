"""Ready materials for simple models; made once, when first asked for."""

from functools import cache

import numpy as np

from sceneq_tools.room.mesh import Colour, Material
from sceneq_tools.room.textures import textures


def plain(colour: Colour, shine: float = 0.1, gloss: float = 20.0) -> Material:
    """An even surface; each call makes a material of its own."""
    return Material(colour=colour, shine=shine, gloss=gloss)


def pictured(texture: np.ndarray, shine: float = 0.05) -> Material:
    """A surface that shows a picture as it is."""
    return Material(colour=(1.0, 1.0, 1.0), texture=texture, shine=shine)


@cache
def oak() -> Material:
    """Light wood."""
    return pictured(textures.wood(np.random.default_rng(1), (0.70, 0.54, 0.36)))


@cache
def walnut() -> Material:
    """Dark wood."""
    return pictured(textures.wood(np.random.default_rng(2), (0.40, 0.27, 0.18)))


@cache
def bed_linen() -> Material:
    """White cotton."""
    return pictured(textures.fabric(np.random.default_rng(3), (0.90, 0.89, 0.86)), shine=0.0)


@cache
def worktop() -> Material:
    """Speckled stone."""
    return pictured(textures.carpet(np.random.default_rng(4), (0.42, 0.41, 0.40)), shine=0.2)


@cache
def steel() -> Material:
    """Brushed metal."""
    return plain((0.66, 0.67, 0.69), shine=0.5, gloss=40.0)


@cache
def black_plastic() -> Material:
    """For feet, knobs and screens."""
    return plain((0.07, 0.07, 0.08), shine=0.3, gloss=40.0)


@cache
def white_enamel() -> Material:
    """For kitchen machines and doors."""
    return plain((0.90, 0.90, 0.88), shine=0.3, gloss=40.0)


@cache
def leaves() -> Material:
    """Green that is not all the same."""
    return pictured(textures.carpet(np.random.default_rng(5), (0.22, 0.42, 0.16)))
