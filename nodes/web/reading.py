"""What a request says, checked against the same schemas that describe it to others."""

import json
from typing import Any

import jsonschema
from starlette.requests import Request

from sceneq_nodes.web.openapi import PATHS, QUERIES, Schema
from sceneq_nodes.web.problem import ProblemError


async def body_of(request: Request, schema: Schema) -> dict[str, Any]:
    """Return the JSON object in the body; raise ``ProblemError`` when it is not as said."""
    try:
        value = json.loads(await request.body())
    except (ValueError, RecursionError) as error:
        raise ProblemError(400, f"the body is not JSON: {error}") from error
    return dict(checked(value, schema, "body"))


def query_of(request: Request, *names: str) -> dict[str, Any]:
    """Return what is said of ``names`` after the ?; raise ``ProblemError`` when it is wrong."""
    if unknown := sorted(set(request.query_params) - set(names)):
        raise ProblemError(400, f"unknown parameter {unknown[0]:.40}", f"known: {', '.join(names)}")
    said = {name: request.query_params.getlist(name) for name in names}
    if twice := [name for name, values in said.items() if len(values) > 1]:
        raise ProblemError(400, f"{twice[0]} is said twice")
    return {name: _read(v[0], QUERIES[name], name) for name, v in said.items() if v}


def number_in(request: Request, name: str) -> int:
    """Return a number of the path; raise ``ProblemError`` when there can be no such thing."""
    try:
        return int(_read(request.path_params[name], PATHS[name], name))
    except ProblemError as problem:
        raise ProblemError(404, problem.detail) from problem


def checked(value: Any, schema: Schema, where: str) -> Any:
    """Return ``value``; raise ``ProblemError`` when it is not as ``schema`` says."""
    try:
        jsonschema.validate(value, schema, jsonschema.Draft202012Validator)
    except jsonschema.ValidationError as error:
        place = "/".join((where, *(str(part) for part in error.absolute_path)))
        raise ProblemError(400, f"{place}: {error.message:.200}") from error
    return value


def _read(text: str, schema: Schema, name: str) -> Any:
    is_number = schema.get("type") == "integer" and text.isascii() and text.isdigit()
    return checked(int(text) if is_number and len(text) < 12 else text, schema, name)
