"""The places of a scene that a camera may find itself at again."""

from collections.abc import Iterable
from dataclasses import dataclass

from sceneq_core.arrays import Float64
from sceneq_core.places.features import Features, features_of, pairs
from sceneq_core.places.place import Place
from sceneq_core.places.rigid_fit import fit_rigid
from sceneq_core.places.sighting import Sighting, SightingParams, confirmed


@dataclass(frozen=True, slots=True)
class _Known:
    place: Place
    features: Features


class Atlas:
    """Recognises places: by features, then by where they are, then by surface and brightness."""

    def __init__(self, params: SightingParams) -> None:
        self._params = params
        self._known: dict[int, _Known] = {}

    def __len__(self) -> int:
        """Return the number of places known."""
        return len(self._known)

    def learn(self, places: Iterable[Place]) -> None:
        """Let ``places`` be those that are known; features of the same pictures are kept."""
        self._known = {place.seq: self._known_of(place) for place in places}

    def sightings(self, seen: Place) -> list[Sighting]:
        """Return where ``seen``, whose pose is in a frame of its own, may have been taken."""
        features = features_of(seen, self._params.features)
        view = seen.view(self._params.depth)
        found = []
        for known in self._candidates(features):
            guess = self._guess(features, known.features)
            if guess is not None:
                T_place_seen, agreeing = guess
                sighting = confirmed(seen, view, known.place, T_place_seen, agreeing, self._params)
                if sighting is not None:
                    found.append(sighting)
        return found

    def _known_of(self, place: Place) -> _Known:
        before = self._known.get(place.seq)
        if before is not None and before.place.jpeg == place.jpeg:
            return _Known(place, before.features)
        return _Known(place, features_of(place, self._params.features))

    def _candidates(self, seen: Features) -> list[_Known]:
        """Return the places that share the most of their strongest features with ``seen``."""
        params = self._params
        few = seen.strongest(params.features.first)
        shared = []
        for seq, known in self._known.items():
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
