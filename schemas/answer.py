"""The answer to a question as JSON Schema (2020-12): what a client may rely on.

Fields may be added within version 1; none is taken away or changes its meaning.
"""

from typing import Any

Schema = dict[str, Any]

FORMS = ("find", "where", "what", "count", "exists", "when", "picture")

_TEXT: Schema = {"type": "string"}
_NUMBER: Schema = {"type": "number"}
_COUNT: Schema = {"type": "integer", "minimum": 0}
_ID: Schema = {"type": "integer", "minimum": 1}
_IDS: Schema = {"type": "array", "items": _ID}
_SHARE: Schema = {"type": "number", "minimum": 0, "maximum": 1}
_POINT: Schema = {"type": "array", "items": _NUMBER, "minItems": 3, "maxItems": 3}
_STATUS: Schema = {"enum": ["found", "ambiguous", "not_found"]}


def _object(required: Schema, **optional: Schema) -> Schema:
    return {
        "type": "object",
        "properties": {**required, **optional},
        "required": list(required),
    }


_BOX = _object({"min": _POINT, "max": _POINT})
_THING = _object({"id": _ID, "label": _TEXT})
_LANDMARK = _object({"id": _ID, "label": _TEXT, "distance_m": _NUMBER})
_VIEW = _object({"seq": _COUNT, "box_xyxy": {"type": "array"}, "key": _TEXT})
_STATE: Schema = {"enum": ["tentative", "confirmed", "stale", "removed"]}

_INSTANCE = _object(
    {
        "id": _ID,
        "label": _TEXT,
        "label_p": _SHARE,
        "p": _SHARE,
        "cosine": _NUMBER,
        "role": {"enum": ["object", "floor", "wall", "ceiling"]},
        "centre": _POINT,
        "box_aabb": _BOX,
        "box_oriented": {"type": "object"},
        "state": _STATE,
        "first_seen_ns": {"type": "integer"},
        "last_seen_ns": {"type": "integer"},
        "views": {"type": "array", "items": _VIEW},
    },
    supported_by={"type": ["integer", "null"]},
    inside={"type": ["integer", "null"]},
    neighbours=_IDS,
)

_SEEN = _object(
    {
        "id": _ID,
        "label": _TEXT,
        "p": _SHARE,
        "state": _STATE,
        "last_seen_ns": {"type": "integer"},
        "age_s": _NUMBER,
        "centre": _POINT,
    }
)

_ASKED = {
    "status": _STATUS,
    "question": _TEXT,
    "form": {"enum": list(FORMS)},
    "said": _TEXT,
    "instances": {"type": "array", "items": _INSTANCE},
    "confidence": _object(
        {"p_max": _SHARE, "margin": _SHARE, "entropy_norm": _SHARE, "T": _NUMBER}
    ),
    "route": {"enum": ["fast", "reasoned", "fallback"]},
    "reason": _TEXT,
}

_FACTS: dict[str, Schema] = {
    "exists": {"enum": ["yes", "no", "unsure"]},
    "count": _object(
        {
            "sure": _COUNT,
            "possible": _COUNT,
            "expected": {"type": "number", "minimum": 0},
            "sure_ids": _IDS,
            "possible_ids": _IDS,
        }
    ),
    "where": {
        "type": "object",
        "properties": {"said": _TEXT, "on": _THING, "in": _THING, "near": _LANDMARK},
        "required": ["said"],
    },
    "last_seen": {"type": "array", "items": _SEEN},
    "gone": _SEEN,
    "missing": _TEXT,
    "nearest_miss": _object({"id": _ID, "label": _TEXT, "p": _SHARE}, where=_TEXT),
}

ANSWER: Schema = {
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "title": "sceneq.answer.v1",
    "description": "The answer to a question: sceneq/query/SCENE/instances and .../ask",
    **_object(
        {
            **_ASKED,
            "cost": _object(
                {"vlm_calls": _COUNT, "tokens": {"type": "object"}, "ms": {"type": "object"}}
            ),
            "map": _object({"epoch": _COUNT, "seq": _COUNT}),
            "query_id": _TEXT,
            "took_ms": _NUMBER,
        },
        **_FACTS,
        targets={"type": "array", "items": _object(_ASKED, **_FACTS)},
    ),
}
"""``targets`` has an answer for each of several things that were asked for at once."""
