"""Logistics that pass names on, fitted on rooms and tested on others."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from sceneq_core.evaluation.reliability import calibration_error, equal_width_bins
from sceneq_core.teaching.logistic import Logistic, fit_logistic
from sceneq_nodes._likeness_file import FORMAT, logistic_json
from sceneq_tools.evaluation.likeness import Pairs, RoomPairs

BINS = 10
PARTS = ("alike", "again", "place")


@dataclass(frozen=True, slots=True)
class Score:
    """How good probabilities are on ``pairs``, of which ``same`` are.

    ``passed`` with p of 0.5 at least, ``right`` of these; ``ece`` over the p of being the same.
    """

    pairs: int
    same: int
    log_loss: float
    ece: float
    passed: int
    right: int

    def as_dict(self) -> dict[str, float]:
        """Return the content of a report."""
        return {name: round(getattr(self, name), 4) for name in self.__slots__}


@dataclass(frozen=True, slots=True)
class LikenessFit:
    """The logistics by part, their scores on the rooms fitted on and on others."""

    logistics: dict[str, Logistic]
    fitted: dict[str, Score]
    tested: dict[str, Score]


def fit_likeness(rooms: Sequence[RoomPairs], others: Sequence[RoomPairs]) -> LikenessFit:
    """Fit on ``rooms``, test on ``others``; raise ``ValueError`` when there is nothing to fit."""
    pairs = {part: _joined(rooms, part) for part in PARTS}
    logistics = {part: fit_logistic(one.measures, one.same) for part, one in pairs.items()}
    fitted = {part: score(logistics[part], one) for part, one in pairs.items()}
    tested = {part: score(logistics[part], _joined(others, part)) for part in PARTS if others}
    return LikenessFit(logistics, fitted, tested)


def score(logistic: Logistic, pairs: Pairs) -> Score:
    """Return how well ``logistic`` does on pairs."""
    p, same = logistic.p(pairs.measures), pairs.same
    likely = np.clip(np.where(same, p, 1.0 - p), 1e-12, 1.0)
    passed = p >= 0.5
    return Score(
        pairs=len(same),
        same=int(same.sum()),
        log_loss=float(-np.log(likely).mean()),
        ece=calibration_error(equal_width_bins(p, same, BINS)),
        passed=int(passed.sum()),
        right=int((passed & same).sum()),
    )


def document(fit: LikenessFit, key: str, rooms: Sequence[RoomPairs]) -> dict[str, Any]:
    """Return the content of likeness.json."""
    return {
        "format": FORMAT,
        "encoders": {
            key: {
                **{part: logistic_json(fit.logistics[part]) for part in PARTS},
                "recordings": {room.name: room.sha256 for room in rooms},
                "fitted": {part: one.as_dict() for part, one in fit.fitted.items()},
                "tested": {part: one.as_dict() for part, one in fit.tested.items()},
            }
        },
    }


def _joined(rooms: Sequence[RoomPairs], part: str) -> Pairs:
    """Return the pairs of all rooms; of a place, only the overlap counts."""
    found = [room.alike if part == "alike" else room.again for room in rooms]
    width = 1 if part == "place" else None
    measures = np.concatenate([one.measures[:, :width] for one in found])
    return Pairs(measures, np.concatenate([one.same for one in found]))
