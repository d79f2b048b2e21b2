"""Answers as clients see them: plain JSON objects, finite and rounded (mm, 4 digits)."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from sceneq_core.arrays import Float64
from sceneq_core.mapping.delta import STALE, Instance, Place
from sceneq_core.routing.answer import Answer, Match, Naming
from sceneq_core.routing.gate import Confidence
from sceneq_core.routing.labels import Label
from sceneq_core.routing.revision import Revision
from sceneq_core.routing.scene import SceneInstance, ViewRef
from sceneq_schemas.topics import VIEW_IMAGE

Json = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Stamp:
    """What the process adds to an answer: who asked, the time it took, the map's age, and what
    the probabilities were calibrated by."""

    scene: str
    query_id: str
    map_age_s: float
    took_ms: float
    stage_ms: Mapping[str, float]
    calibration: str


def answer_json(answer: Answer, k: int, stamp: Stamp) -> Json:
    """Return an answer with its best ``k`` matches."""
    return {
        "status": answer.status,
        "question": answer.question,
        "instances": [_match_json(match, stamp.scene) for match in answer.matches[:k]],
        "confidence": {**_confidence_json(answer.confidence), "presence": _p(answer.presence)},
        "route": answer.route,
        "cached": answer.cached,
        "reason": _reason(answer),
        "cost": _cost_json(answer, stamp),
        **_stamp_json(answer.revision, stamp),
    }


def _reason(answer: Answer) -> str:
    """Say so when the best match may not be where it is said to be."""
    best = answer.matches[0].instance.geometry if answer.matches else None
    if best is None or best.state != STALE:
        return answer.reason
    return f"{answer.reason}; {best.instance_id} was looked for there and not found, or in part"


def naming_json(naming: Naming, stamp: Stamp) -> Json:
    """Return what an instance is called."""
    return {
        "status": naming.status,
        "instance": instance_json(naming.instance, stamp.scene),
        "labels": [
            {
                "label": label.name,
                "p": _p(label.p),
                "cosine": _p(label.cosine),
                "source": label.source,
            }
            for label in naming.labels
        ],
        "confidence": _confidence_json(naming.confidence),
        "route": naming.route,
        "cached": naming.cached,
        "reason": naming.reason,
        "cost": _cost_json(naming, stamp),
        **_stamp_json(naming.revision, stamp),
    }


def listing_json(
    instances: Iterable[SceneInstance | Instance], revision: Revision, stamp: Stamp
) -> Json:
    """Return instances as a list; ``p`` is that of the label, bare geometry has neither."""
    listed = [
        instance_json(one, stamp.scene)
        if isinstance(one, SceneInstance)
        else _instance_json(one, None, (), stamp.scene)
        for one in instances
    ]
    return {"status": "listed", "instances": listed, **_stamp_json(revision, stamp)}


def instance_json(instance: SceneInstance, scene: str) -> Json:
    """Return an instance with its boxes (metres, scene frame) and evidence."""
    return _instance_json(instance.geometry, instance.label, instance.views, scene)


def _instance_json(
    geometry: Instance, label: Label | None, views: Iterable[ViewRef], scene: str
) -> Json:
    low, high = geometry.aabb_world
    return {
        "id": geometry.instance_id,
        "label": label.name if label else None,
        "p": _p(label.p) if label else 0.0,
        "label_source": label.source if label else None,
        "role": geometry.role,
        "centre": _mm(geometry.centre_world),
        "box_aabb": {"min": _mm(low), "max": _mm(high)},
        "box_oriented": {
            "centre": _mm(geometry.T_world_box[:3, 3]),
            "size": _mm(geometry.box_size_m),
            "rotation": [
                [round(part, 6) for part in row] for row in geometry.T_world_box[:3, :3].tolist()
            ],
        },
        "supported_by": geometry.supported_by or None,
        "inside": geometry.inside or None,
        "neighbours": geometry.neighbour_id.tolist(),
        "state": geometry.state,
        "state_since_ns": geometry.state_since_ns,
        "first_seen_ns": geometry.first_seen_ns,
        "last_seen_ns": geometry.last_seen_ns,
        "places": [_place_json(place) for place in geometry.places],
        "views": [_view_json(view, scene) for view in views],
    }


def _place_json(place: Place) -> Json:
    low, high = place.aabb_world
    return {
        "centre": _mm(place.centre_world),
        "box_aabb": {"min": _mm(low), "max": _mm(high)},
        "from_ns": place.from_ns,
        "until_ns": place.until_ns,
    }


def map_json(revision: Revision, age_s: float) -> Json:
    """Return which map was used, and how long ago it last changed."""
    age = round(age_s, 3) if math.isfinite(age_s) else None
    return {"epoch": revision.epoch, "seq": revision.seq, "age_s": age}


def _cost_json(answer: Answer | Naming, stamp: Stamp) -> Json:
    usage = answer.usage
    return {
        "vlm_calls": answer.vlm_calls,
        "tokens": {"in": usage.tokens_in, "out": usage.tokens_out},
        "money": round(usage.money, 6),
        "ms": {stage: round(ms, 2) for stage, ms in stamp.stage_ms.items()},
    }


def _match_json(match: Match, scene: str) -> Json:
    """``p`` is that of being meant; that of the label goes beside it."""
    told = instance_json(match.instance, scene)
    head = {"id": told.pop("id"), "label": told.pop("label"), "label_p": told.pop("p")}
    return {**head, "p": _p(match.p), "cosine": _p(match.cosine), **told}


def _view_json(view: ViewRef, scene: str) -> Json:
    return {
        "seq": view.seq,
        "box_xyxy": [round(side, 1) for side in view.box_xyxy],
        "key": f"{_image_key(scene)}?seq={view.seq}",
    }


@cache
def _image_key(scene: str) -> str:
    return VIEW_IMAGE.key(scene=scene)


def _confidence_json(confidence: Confidence) -> Json:
    return {
        "p_max": _p(confidence.p_max),
        "margin": _p(confidence.margin),
        "entropy_norm": _p(confidence.entropy_norm),
        "p_null": _p(confidence.p_null),
        "T": _p(confidence.temperature),
    }


def _stamp_json(revision: Revision, stamp: Stamp) -> Json:
    return {
        "map": map_json(revision, stamp.map_age_s),
        "calibration": stamp.calibration,
        "query_id": stamp.query_id,
        "took_ms": round(stamp.took_ms, 2),
    }


def _p(value: float) -> float:
    return round(float(value), 4)


def _mm(point_m: Float64) -> list[float]:
    return [round(part, 3) for part in point_m.tolist()]
