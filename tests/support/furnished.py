"""A furnished room without images: instances with boxes, and an encoder that knows words.

The encoder gives every word a fixed direction; an instance's descriptor is that of its name, plus
noise. So tests choose how sure the encoder is (``noise``), and nothing has to be rendered.
"""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from sceneq_core.encoding.encoder import Crop
from sceneq_core.mapping.delta import Instance
from sceneq_core.routing.labels import Labeller, LabelSet, named
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.router import Router, RouterParams
from sceneq_core.routing.scene import Scene, SceneSnapshot, ViewRef

UP = np.array([0.0, 0.0, 1.0])
VIEWPOINT = np.array([0.0, -3.0, 1.5])


class Thing(NamedTuple):
    name: str
    low: tuple[float, float, float]
    high: tuple[float, float, float]


ROOM = (
    Thing("floor", (-3, -3, -0.02), (3, 3, 0.0)),
    Thing("wall", (-3, 3, 0), (3, 3.1, 2.6)),
    Thing("white couch", (-2.5, 1.8, 0), (-0.5, 2.8, 0.8)),
    Thing("pillow", (-2.3, 2.2, 0.42), (-1.9, 2.6, 0.8)),
    Thing("coffee table", (-2.0, 0.4, 0), (-1.0, 1.0, 0.45)),
    Thing("red cup", (-1.6, 0.6, 0.45), (-1.5, 0.7, 0.55)),
    Thing("blue cup", (1.0, 2.2, 0.95), (1.1, 2.3, 1.05)),
    Thing("kitchen counter", (0.5, 2.0, 0), (2.5, 2.6, 0.95)),
    Thing("picture", (-1.8, 2.96, 1.4), (-1.2, 3.0, 2.0)),
    Thing("trash can", (-0.8, 0.5, 0), (-0.5, 0.8, 0.5)),
    Thing("chair", (1.0, -1.0, 0), (1.5, -0.5, 0.9)),
    Thing("chair", (2.0, 0.8, 0), (2.5, 1.3, 0.9)),
    Thing("chair", (-2.8, -2.0, 0), (-2.3, -1.5, 0.9)),
    Thing("box", (1.1, -0.9, 0), (1.4, -0.6, 0.3)),
    Thing("dining table", (0.8, -2.4, 0), (2.4, -1.4, 0.75)),
    Thing("lamp", (-2.9, 2.0, 0), (-2.6, 2.3, 1.6)),
)


@dataclass(frozen=True, slots=True)
class WordParams:
    """No parameters."""


class WordEncoder:
    """Words to directions, texts to the mean of their words'."""

    Params = WordParams
    model_id = "words"
    dim = 256
    temperature = 0.1
    ceiling = 1.0

    def __init__(self, params: WordParams | None = None) -> None:
        self.params = params or WordParams()

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[np.ndarray, np.ndarray]:
        raise NotImplementedError("this encoder has no eyes")

    def encode_texts(self, texts: Sequence[str]) -> np.ndarray:
        rows = [np.sum([_direction(word, self.dim) for word in t.split()], axis=0) for t in texts]
        vectors = np.array(rows, np.float32)
        return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def instance(instance_id: int, thing: Thing, *, state: str = "confirmed") -> Instance:
    low, high = np.array(thing.low, float), np.array(thing.high, float)
    T_world_box = np.eye(4)
    T_world_box[:3, 3] = (low + high) / 2
    return Instance(
        instance_id=instance_id,
        state=state,
        merged_into=0,
        parent=0,
        superpoint_id=np.array([instance_id], np.int32),
        voxel_count=100,
        centre_world=(low + high) / 2,
        aabb_world=np.stack([low, high]),
        T_world_box=T_world_box,
        box_size_m=high - low,
        first_seen_ns=1_000,
        last_seen_ns=9_000,
    )


def descriptors(things: Sequence[Thing], noise: float, seed: int = 7) -> dict[int, np.ndarray]:
    if not things:
        return {}
    clean = WordEncoder().encode_texts([thing.name for thing in things])
    rng = np.random.default_rng(seed)
    noisy = clean + noise * rng.normal(size=clean.shape) / np.sqrt(clean.shape[1])
    unit = (noisy / np.linalg.norm(noisy, axis=1, keepdims=True)).astype(np.float32)
    return {i + 1: row for i, row in enumerate(unit)}


def views(things: Sequence[Thing]) -> dict[int, tuple[ViewRef, ...]]:
    return {i + 1: (ViewRef(10 * (i + 1), (1.0, 2.0, 30.0, 40.0)),) for i in range(len(things))}


def furnish(
    things: Sequence[Thing] = ROOM, noise: float = 0.3, label_set: LabelSet | None = None
) -> Scene:
    scene = Scene(Labeller(label_set or named("scannet200"), WordEncoder()))
    instances = [instance(i + 1, thing) for i, thing in enumerate(things)]
    scene.apply_map(Revision(5, 12, 110, 9_000), instances, UP, full=True)
    scene.apply_views(5, views(things))
    scene.apply_descriptors(5, descriptors(things, noise), np.zeros(0, np.int32))
    scene.move_viewpoint(VIEWPOINT)
    return scene


def snapshot(things: Sequence[Thing] = ROOM, noise: float = 0.3) -> SceneSnapshot:
    return furnish(things, noise).snapshot()


def router(params: RouterParams | None = None, temperature: float | None = None) -> Router:
    encoder = WordEncoder()
    encoder.temperature = temperature or WordEncoder.temperature
    return Router(params or RouterParams(), encoder, Labeller(named("scannet200"), encoder))


def ids(name: str, things: Sequence[Thing] = ROOM) -> set[int]:
    return {i + 1 for i, thing in enumerate(things) if name in thing.name}


def _direction(word: str, dim: int) -> np.ndarray:
    return np.random.default_rng(zlib.crc32(word.encode())).normal(size=dim)
