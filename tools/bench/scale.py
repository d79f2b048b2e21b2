"""A large scene in memory: what a question costs, and what a change does, beside the product."""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from sceneq_core.arrays import Float32, UInt8
from sceneq_core.encoding.encoder import Crop
from sceneq_core.encoding.joint import unit
from sceneq_core.mapping.delta import CONFIRMED, Instance
from sceneq_core.routing.labels import Labeller, named
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.router import Router, RouterParams
from sceneq_core.routing.scene import Scene, ViewRef
from sceneq_tools.bench.measurement import Measurement, Options, in_turns_ms, latency

INSTANCES, DIM = 10_000, 512
CHANGED = 30
"""Instances that a keyframe changes: about what a camera sees at once."""
LEAST = 50
QUESTION, COLOURED, SPATIAL = "mug", "red mug", "the red mug on the table"
BESIDE = "matrix times vector"


def scale(options: Options) -> Iterator[Measurement]:
    """Ask about ten thousand instances, and change some of them."""
    encoder = RandomEncoder()
    labeller = Labeller(named("scannet200"), encoder)
    router = Router(RouterParams(), encoder, labeller)
    instances = [instance(number) for number in range(1, INSTANCES + 1)]
    scene = Scene(labeller)
    fill(scene, instances)
    snapshot = scene.snapshot()
    matrix, vector = np.asarray(snapshot.descriptors, np.float32), encoder.encode_texts(["mug"])[0]
    seen_again = iter(range(2, 1_000_000_000))

    def change() -> None:
        seq = next(seen_again)
        first = seq * CHANGED % (INSTANCES - CHANGED)
        changed = instances[first : first + CHANGED]
        scene.apply_map(Revision(1, seq, seq), changed, np.array([0.0, 0.0, 1.0]), full=False)
        scene.snapshot()

    questions = {text: router.read(text) for text in (QUESTION, COLOURED, SPATIAL)}
    works: list[Callable[[], object]] = [lambda: matrix @ vector, change]
    works += [partial(router.answer, snapshot, question) for question in questions.values()]
    product_ms, changed_ms, *asked_ms = in_turns_ms(works, options.seconds, 2, LEAST)
    of = f"of {INSTANCES:,} x {DIM}".replace(",", " ")
    for text, taken_ms in zip(questions, asked_ms, strict=True):
        yield from latency(f"'{text}' {of},", taken_ms, BESIDE, product_ms)
    yield from latency(f"{CHANGED} {of} changed,", changed_ms, BESIDE, product_ms)


class RandomEncoder:
    """Random directions: what a vector means does not change what it costs to compare it."""

    model_id, dim, temperature, ceiling = "random", DIM, 0.05, 0.9

    def encode_crops(self, crops: Sequence[Crop]) -> tuple[Float32, Float32]:
        """Return a descriptor (N, dim) of the colours of each crop; it is its own feature."""
        rows = self._rows([digest(crop.rgb) for crop in crops])
        return rows, rows

    def encode_texts(self, texts: Sequence[str]) -> Float32:
        """Return (N, dim), L2-normalised."""
        return self._rows([digest(np.frombuffer(text.encode(), np.uint8)) for text in texts])

    def _rows(self, seeds: Sequence[int]) -> Float32:
        rows = [direction(np.random.default_rng(seed)) for seed in seeds]
        return np.array(rows, np.float32).reshape(-1, DIM)


def direction(rng: np.random.Generator) -> Float32:
    """Return a random vector (DIM,) of length 1."""
    return unit(rng.normal(size=DIM).astype(np.float32))


def digest(values: UInt8) -> int:
    """Return a number that depends on all values and their order."""
    return int.from_bytes(values.tobytes(), "big")


def fill(scene: Scene, instances: Sequence[Instance]) -> None:
    """Tell a scene of instances with a view and a descriptor each."""
    rng = np.random.default_rng(1)
    ids = [one.instance_id for one in instances]
    views = {number: (ViewRef(1, (100.0, 100.0, 200.0, 200.0)),) for number in ids}
    rows = {number: direction(rng) for number in ids}
    scene.apply_map(Revision(1, 1, 1), instances, np.array([0.0, 0.0, 1.0]), full=True)
    scene.apply_views(1, views)
    scene.apply_descriptors(1, rows, np.zeros(0, np.int32))


def instance(number: int) -> Instance:
    """Return a box of 40 cm somewhere in a large building."""
    centre = np.random.default_rng(number).uniform(0, 100, 3)
    T_world_box = np.eye(4)
    T_world_box[:3, 3] = centre
    return Instance(
        instance_id=number,
        state=CONFIRMED,
        merged_into=0,
        parent=0,
        superpoint_id=np.array([number], np.int32),
        voxel_count=1000,
        centre_world=centre,
        aabb_world=np.stack([centre - 0.2, centre + 0.2]),
        T_world_box=T_world_box,
        box_size_m=np.full(3, 0.4),
        first_seen_ns=0,
        last_seen_ns=1,
    )
