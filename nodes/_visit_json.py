"""A visit as JSON: on the bus and in the journal of the map."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from sceneq_core.places.visit import Visit


def visit_json(visit: Visit) -> dict[str, Any]:
    """Return a visit in values that JSON knows."""
    known = visit.T_world_odom
    return {
        "visit": visit.number,
        "robot": visit.robot,
        "origin": visit.origin,
        "first_seq": visit.first_seq,
        "first_stamp_ns": visit.first_stamp_ns,
        "fingerprint": visit.fingerprint,
        "T_world_odom": None if known is None else known.tolist(),
        "evidence": visit.evidence,
    }


def visit_from_json(told: Mapping[str, Any]) -> Visit:
    """Return the visit that ``visit_json`` was given; raise ``ValueError`` for anything else."""
    try:
        known = told["T_world_odom"]
        return Visit(
            int(told["visit"]),
            str(told["robot"]),
            str(told["origin"]),
            int(told["first_seq"]),
            int(told["first_stamp_ns"]),
            int(told["fingerprint"]),
            None if known is None else np.array(known, np.float64).reshape(4, 4),
            str(told["evidence"]),
        )
    except (KeyError, TypeError) as error:
        raise ValueError(f"no visit: {error!r}") from error
