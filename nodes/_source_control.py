"""Requests that change what a source shows, as queries on ``sceneq/ctl/<node>/<verb>``."""

import json
from collections.abc import Mapping

from sceneq_core.ingest.source import RefusedError, Source
from sceneq_nodes._bus import QueryError, Reply, Request
from sceneq_nodes._wire import json_bytes
from sceneq_schemas.topics import CONTROL

VERBS = ("list", "move", "remove", "add", "look")
READ_ONLY = "list"


def control(source: Source, request: Request) -> Reply | None:
    """Do what a request asks of ``source``: arguments by ``?thing=mug;...`` or as a JSON object.

    A wildcard is answered only where nothing changes.

    Raises:
        QueryError: ``refused`` with the source's reason, ``bad_request`` when nobody can read it.
    """
    verb = request.ids["verb"]
    if request.wildcard and verb != READ_ONLY:
        return None
    try:
        done = source.control(verb, _arguments(request))
    except RefusedError as error:
        raise QueryError("refused", str(error), error.hint) from error
    return Reply(json_bytes(done), CONTROL.encoding)


def _arguments(request: Request) -> Mapping[str, str]:
    """Return parameters and payload together; the payload goes over the parameters."""
    if not request.payload:
        return request.parameters
    try:
        given = json.loads(request.payload)
    except (ValueError, RecursionError) as error:
        raise QueryError("bad_request", f"not JSON: {error}", '{"thing": "mug"}') from error
    if not isinstance(given, dict) or not all(isinstance(v, str | int) for v in given.values()):
        raise QueryError("bad_request", "expected an object of texts", '{"thing": "mug"}')
    return {**request.parameters, **{name: str(value) for name, value in given.items()}}
