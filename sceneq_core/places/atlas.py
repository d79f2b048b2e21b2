"""The places of a scene that a camera may find itself at again."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float64
from sceneq_core.places.features import Features, features_of, pairs
from sceneq_core.places.place import Place
from sceneq_core.places.rigid_fit import fit_rigid
from sceneq_core.places.sighting import Sighting, SightingParams, confirmed


@dataclass(frozen=True, slots=True)
class Known:
    """A place with its features, which cost more than all comparisons with them."""

    place: Place
    features: Features


class Atlas:
    """Recognises places: by features, then by where they are, then by surface and brightness."""

    def __init__(self, params: SightingParams) -> None:
        self._params = params
        self._known: dict[int, Known] = {}

    def __len__(self) -> int:
        """Return the number of places known."""
        return len(self._known)

    def learn(self, places: Iterable[Place]) -> frozenset[int]:
        """Let ``places`` be those that are known; features of the same pictures are kept.

        Returns the numbers of those that are new, lie elsewhere now, or are gone.
        """
        before, self._known = self._known, {}
        for place in places:
            known = before.get(place.seq)
            if known is not None and known.place.jpeg == place.jpeg:
                self._known[place.seq] = Known(place, known.features)
            else:
                self._known[place.seq] = self.look(place)
        return _changed(before, self._known)

    def look(self, seen: Place) -> Known:
        """Return a place with its features, to be compared with those known."""
        return Known(seen, features_of(seen, self._params.features))

    def sightings(self, seen: Known, among: Collection[int] | None = None) -> list[Sighting]:
        """Return where ``seen``, whose pose is in a frame of its own, may have been taken.

        ``among``: the numbers of the places that it is compared with, ``None`` = all.
        """
        candidates = self._candidates(seen.features, among)
        if not candidates:
            return []
        view = seen.place.view(self._params.depth)
        found = []
        for known in candidates:
            guess = self._guess(seen.features, known.features)
            if guess is not None:
                found.append(confirmed(seen.place, view, known.place, *guess, self._params))
        return [sighting for sighting in found if sighting is not None]

    def _candidates(self, seen: Features, among: Collection[int] | None) -> list[Known]:
        """Return the places that share the most of their strongest features with ``seen``."""
        params = self._params
        few = seen.strongest(params.features.first)
        shared = []
        for seq, known in self._known.items():
            if among is not None and seq not in among:
                continue
            others = known.features.strongest(params.features.first)
            count = len(pairs(few, others, params.features.ratio))
            shared.append((count, -seq))
        best = sorted(shared, reverse=True)[: params.candidates]
        return [self._known[-seq] for count, seq in best if count >= params.min_shared]

    def _guess(self, seen: Features, known: Features) -> tuple[Float64, int] | None:
        """Return T_place_seen and how many features agree with it, if they are enough."""
        row = pairs(seen, known, self._params.features.ratio)
        ours, theirs = seen.points_camera[row[:, 0]], known.points_camera[row[:, 1]]
        fit = fit_rigid(ours, theirs, self._params.fit)
        if fit is None or fit.agrees.sum() < self._params.min_features:
            return None
        return fit.T_b_a, int(fit.agrees.sum())


def _changed(before: Mapping[int, Known], now: Mapping[int, Known]) -> frozenset[int]:
    return frozenset(
        seq
        for seq in before.keys() | now.keys()
        if seq not in before or seq not in now or _differ(before[seq].place, now[seq].place)
    )


def _differ(one: Place, other: Place) -> bool:
    moved = not np.array_equal(one.T_world_camera, other.T_world_camera)
    return moved or one.jpeg != other.jpeg
