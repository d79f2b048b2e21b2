"""Pairs of true things and pairs of mapped things: what names are passed on by, measured."""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import numpy as np

from sceneq_core.arrays import Bool, Float64, UInt8
from sceneq_core.encoding.describe import Describer
from sceneq_core.mapping.delta import OBJECT, TENTATIVE, Instance
from sceneq_core.mapping.mapper import Mapper, MapperParams
from sceneq_core.mapping.replica import MapReplica
from sceneq_core.teaching.evidence import box_overlap
from sceneq_core.teaching.taught import Looks
from sceneq_core.views.jpeg import rgb_from_jpeg
from sceneq_core.views.selector import ViewSelector
from sceneq_nodes._backends import build
from sceneq_tools.evaluation.oracle import ingested, is_candidate, true_instances, true_views
from sceneq_tools.evaluation.retrieval_setup import Setup
from sceneq_tools.evaluation.true_things import THINGS_FILE, read_things

IS_THING = 0.25
"""A mapped instance is the true thing whose box it overlaps with by so much at least."""


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """``measures`` (N, M) of pairs and whether they are ``same`` (N,)."""

    measures: Float64
    same: Bool

    @classmethod
    def of(cls, found: Sequence[tuple[tuple[float, ...], bool]], width: int) -> "Pairs":
        """Return pairs of ``width`` measures."""
        measures = np.array([one for one, _ in found], np.float64).reshape(-1, width)
        return cls(measures, np.array([same for _, same in found], np.bool_))


@dataclass(frozen=True, slots=True, eq=False)
class RoomPairs:
    """What one recording says.

    ``alike``: two things of the room, cosine: of one category? ``again``: an instance of each of
    two maps from disjoint keyframes, overlap and cosine: the same thing? ``sha256`` names the data.
    """

    name: str
    sha256: str
    alike: Pairs
    again: Pairs


def pairs_in(folder: Path, setup: Setup) -> RoomPairs:
    """Return the pairs of a rendered recording with masks.

    Raises:
        UserError: a file of the recording that is missing or malformed.
    """
    things = {thing.id: thing for thing in read_things(folder / THINGS_FILE)}
    looks = _looks(setup, true_views(folder, setup))
    alike = [
        ((_cosine(looks[a], looks[b]),), things[a].names[0] == things[b].names[0])
        for a, b in permutations(sorted(looks), 2)
    ]
    digest = hashlib.sha256((folder / THINGS_FILE).read_bytes()).hexdigest()
    name = folder.resolve().name
    again = list(_again(folder, setup))
    return RoomPairs(name, digest, Pairs.of(alike, 1), Pairs.of(again, 2))


def _again(folder: Path, setup: Setup) -> Iterator[tuple[tuple[float, float], bool]]:
    """Yield overlap, cosine and truth of instances of two maps from even and odd keyframes."""
    things = [one for one in read_things(folder / THINGS_FILE) if is_candidate(one)]
    truth = true_instances(folder, things)
    runs = []
    for parity in (0, 1):
        looks = _looks(setup, true_views(folder, setup, _of(parity)))
        mapped = _map(folder, setup, parity)
        known = ((one, _thing_of(one, truth)) for one in mapped)
        runs.append([(one, thing, looks[thing]) for one, thing in known if thing in looks])
    for first, thing, look in runs[0]:
        overlap = box_overlap(first.aabb_world, np.stack([one.aabb_world for one, _, _ in runs[1]]))
        for shared, (_, other, other_look) in zip(overlap.tolist(), runs[1], strict=True):
            yield (shared, _cosine(look, other_look)), thing == other


def _of(parity: int) -> Callable[[int], bool]:
    """Return what says whether a number is even (``parity`` 0) or odd (1)."""
    return lambda number: number % 2 == parity


def _map(folder: Path, setup: Setup, parity: int) -> list[Instance]:
    """Return the objects of a map made from every second keyframe and the masks beside it."""
    segmenter = build("segmenter", {"kind": "files", "path": str(folder)}, ("segmenter",))
    mapper, replica, number = Mapper(MapperParams()), MapReplica(), 0
    for taken in ingested(folder, setup):
        if taken.keyframe is not None:
            if _of(parity)(number):
                frame = taken.keyframe
                replica.apply(mapper.integrate(frame, segmenter.segment(frame)))
            number += 1
    instances = replica.instances.values()
    return [one for one in instances if one.role == OBJECT and one.state != TENTATIVE]


def _thing_of(instance: Instance, truth: Sequence[Instance]) -> int:
    overlap = box_overlap(instance.aabb_world, np.stack([one.aabb_world for one in truth]))
    best = int(np.argmax(overlap))
    return truth[best].instance_id if overlap[best] >= IS_THING else 0


def _looks(setup: Setup, selector: ViewSelector) -> dict[int, Looks]:
    describer = Describer(setup.encoder, setup.describe)
    found = {}
    for view_set in selector.view_sets():
        described = describer.describe(view_set, lambda view: _rgb(selector.image(view.seq)))
        if described is not None:
            looks = Looks(setup.encoder.model_id, described.descriptor, described.feature)
            found[view_set.instance_id] = looks
    return found


def _rgb(jpeg: bytes | None) -> UInt8 | None:
    return None if jpeg is None else rgb_from_jpeg(jpeg)


def _cosine(one: Looks, other: Looks) -> float:
    return float(one.image @ other.image)
