"""The description of the pages, in OpenAPI 3.1: schemas of answers are those of the bus."""

from importlib.metadata import version
from typing import Any

from sceneq_nodes.web.problem import MEDIA_TYPE, TITLES
from sceneq_schemas.answer import ANSWER

Schema = dict[str, Any]

MAX_ID = 2**31 - 1
MAX_K = 500
MAX_TEXT = 1000
MAX_DEADLINE_MS = 600_000

_ID: Schema = {"type": "integer", "minimum": 1, "maximum": MAX_ID}
_K: Schema = {"type": "integer", "minimum": 1, "maximum": MAX_K}
_NAME: Schema = {"type": "string", "minLength": 1, "maxLength": 100, "pattern": r"\S"}

QUESTION: Schema = {
    "type": "object",
    "properties": {
        "question": {"type": "string", "minLength": 1, "maxLength": MAX_TEXT, "pattern": r"\S"},
        "k": _K,
        "mode": {"enum": ["fast", "reason"]},
        "deadline_ms": {"type": "integer", "minimum": 1, "maximum": MAX_DEADLINE_MS},
    },
    "required": ["question"],
    "additionalProperties": False,
}
TAUGHT: Schema = {
    "type": "object",
    "properties": {"name": _NAME},
    "required": ["name"],
    "additionalProperties": False,
}
QUERIES: dict[str, Schema] = {
    "k": _K,
    "after": {"type": "integer", "minimum": 0, "maximum": MAX_ID},
    "labels": {"type": "string", "minLength": 1, "maxLength": MAX_TEXT},
    "mode": {"enum": ["fast", "reason"]},
}
PATHS: dict[str, Schema] = {
    "id": _ID,
    "seq": {"type": "integer", "minimum": 0, "maximum": MAX_ID},
}
_OBJECT: Schema = {"type": "object"}
_ANSWER: Schema = {"$ref": "#/components/schemas/Answer"}


def document() -> dict[str, Any]:
    """Return the OpenAPI document."""
    answer = {name: part for name, part in ANSWER.items() if name != "$schema"}
    return {
        "openapi": "3.1.0",
        "info": {
            "title": "Scene-Q",
            "version": version("sceneq"),
            "description": "Questions to a live 3D map. Events: a WebSocket at /events.",
        },
        "paths": _paths(),
        "components": {
            "schemas": {"Answer": answer, "Problem": _problem()},
            "securitySchemes": {"token": {"type": "http", "scheme": "bearer"}},
        },
        "security": [{}, {"token": []}],
    }


def _paths() -> dict[str, Any]:
    json_type = "application/json"
    return {
        "/ask": {
            "post": _operation("Ask a question", json_type, _ANSWER, body=QUESTION),
        },
        "/scene": {"get": _operation("How the scene and its nodes are", json_type, _OBJECT)},
        "/labels": {"get": _operation("What things are called here", json_type, _OBJECT)},
        "/instances": {
            "get": _operation("A page of the things", json_type, _OBJECT, query=("k", "after")),
        },
        "/instances/{id}": {"get": _operation("One thing", json_type, _OBJECT, path=("id",))},
        "/instances/{id}/label": {
            "get": _operation(
                *("What a thing is", json_type, _OBJECT),
                path=("id",),
                query=("labels", "k", "mode"),
            ),
        },
        "/instances/{id}/name": {
            "put": _operation("Name a thing", json_type, _OBJECT, path=("id",), body=TAUGHT),
            "delete": _operation("Take its names back", json_type, _OBJECT, path=("id",)),
        },
        "/views/{seq}.jpg": {
            "get": _operation("A keyframe", "image/jpeg", {"type": "string"}, path=("seq",)),
        },
        "/cloud": {
            "get": _operation(
                *("The points of the map", "application/vnd.sceneq.cloud", {"type": "string"})
            ),
        },
    }


def _operation(
    summary: str,
    media_type: str,
    answer: Schema,
    *,
    path: tuple[str, ...] = (),
    query: tuple[str, ...] = (),
    body: Schema | None = None,
) -> dict[str, Any]:
    operation: dict[str, Any] = {
        "summary": summary,
        "parameters": [
            *({"name": n, "in": "path", "required": True, "schema": PATHS[n]} for n in path),
            *({"name": n, "in": "query", "schema": QUERIES[n]} for n in query),
        ],
        "responses": {
            "200": {"description": "Well", "content": {media_type: {"schema": answer}}},
            "default": {
                "description": "Why not",
                "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}},
            },
        },
    }
    if body is not None:
        content = {"application/json": {"schema": body}}
        operation["requestBody"] = {"required": True, "content": content}
    return operation


def _problem() -> Schema:
    text: Schema = {"type": "string"}
    return {
        "type": "object",
        "properties": {
            "type": text,
            "title": {"enum": list(TITLES.values())},
            "status": {"type": "integer"},
            "detail": text,
            "hint": text,
        },
        "required": ["type", "title", "status", "detail"],
    }
