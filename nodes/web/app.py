"""The pages: each asks the bus one thing and hands on what it says."""

import asyncio
import contextlib
import logging
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect

from sceneq_nodes.web.cloud import MEDIA_TYPE
from sceneq_nodes.web.desk import Desk
from sceneq_nodes.web.events import Hub, Listener
from sceneq_nodes.web.guard import TOKEN_PROTOCOL, Access, Guard, protocols
from sceneq_nodes.web.openapi import QUESTION, TAUGHT, document
from sceneq_nodes.web.problem import ProblemError
from sceneq_nodes.web.reading import body_of, number_in, query_of
from sceneq_schemas import topics

log = logging.getLogger(__name__)

STATIC = Path(str(files("sceneq_nodes.web"))) / "static"

Cloud = Callable[[], tuple[str, bytes]]
"""The points of the map as they are now, and a name for their state."""


class Pages:
    """Answers the requests of the web with what the bus says."""

    def __init__(self, desk: Desk, hub: Hub, cloud: Cloud) -> None:
        self._desk = desk
        self._hub = hub
        self._cloud = cloud

    async def ask(self, request: Request) -> Response:
        """POST /ask."""
        said = await body_of(request, QUESTION)
        topic = topics.QUERY_INSTANCES if said.get("mode") == "fast" else topics.QUERY_ASK
        mode = {} if said.get("mode") == "fast" else {"mode": said.get("mode")}
        wanted = {"q": said["question"], "k": said.get("k"), **mode}
        answer = await self._told(topic, wanted | {"deadline_ms": said.get("deadline_ms")})
        self._hub.tell({"type": "answer", "answer": answer})
        return JSONResponse(answer)

    async def scene(self, request: Request) -> Response:
        """GET /scene."""
        query_of(request)
        return JSONResponse(await self._told(topics.QUERY_STATUS, {}))

    async def labels(self, request: Request) -> Response:
        """GET /labels."""
        query_of(request)
        return JSONResponse(await self._told(topics.QUERY_LABELS, {"k": 1}))

    async def instances(self, request: Request) -> Response:
        """GET /instances?k=100&after=0."""
        said = {"k": 100, "after": 0, **query_of(request, "k", "after")}
        return JSONResponse(await self._told(topics.QUERY_INSTANCES, said))

    async def instance(self, request: Request) -> Response:
        """GET /instances/7."""
        query_of(request)
        return JSONResponse(await self._told(topics.QUERY_INSTANCES, _id(request)))

    async def label(self, request: Request) -> Response:
        """GET /instances/7/label?labels=mug,cup."""
        said = query_of(request, "labels", "k", "mode")
        return JSONResponse(await self._told(topics.QUERY_LABEL, _id(request) | said))

    async def name(self, request: Request) -> Response:
        """PUT and DELETE /instances/7/name."""
        query_of(request)
        if request.method == "PUT":
            said = await body_of(request, TAUGHT)
            return JSONResponse(await self._told(topics.TEACH_SET, _id(request) | said))
        return JSONResponse(await self._told(topics.TEACH_FORGET, _id(request)))

    async def view(self, request: Request) -> Response:
        """GET /views/120.jpg."""
        query_of(request)
        jpeg = await run_in_threadpool(self._desk.picture, number_in(request, "seq"))
        return Response(jpeg, media_type="image/jpeg", headers={"Cache-Control": "max-age=3600"})

    async def cloud(self, request: Request) -> Response:
        """GET /cloud: only if it is another than the page has."""
        query_of(request)
        state, data = await run_in_threadpool(self._cloud)
        headers = {"ETag": f'"{state}"', "Cache-Control": "no-cache"}
        if request.headers.get("if-none-match") == headers["ETag"]:
            return Response(status_code=304, headers=headers)
        return Response(data, media_type=MEDIA_TYPE, headers=headers)

    async def events(self, socket: WebSocket) -> None:
        """Tell what happens until the page goes."""
        listener = self._hub.join()
        if listener is None:
            await socket.close(1013, "too many pages listen")
            return
        try:
            offered = (p for p in protocols(socket.headers) if p.startswith(TOKEN_PROTOCOL))
            await socket.accept(next(offered, None))
            await _tell(socket, listener)
        finally:
            self._hub.leave(listener)

    async def _told(self, topic: topics.Topic, said: dict[str, Any]) -> dict[str, Any]:
        return await run_in_threadpool(self._desk.ask, topic, said)


def application(pages: Pages, access: Access) -> ASGIApp:
    """Return the pages behind their guard."""
    app = Starlette(
        routes=[
            Route("/ask", pages.ask, methods=["POST"]),
            Route("/scene", pages.scene),
            Route("/labels", pages.labels),
            Route("/instances", pages.instances),
            Route("/instances/{id}", pages.instance),
            Route("/instances/{id}/label", pages.label),
            Route("/instances/{id}/name", pages.name, methods=["PUT", "DELETE"]),
            Route("/views/{seq}.jpg", pages.view),
            Route("/cloud", pages.cloud),
            Route("/openapi.json", _openapi),
            WebSocketRoute("/events", pages.events),
            Route("/", _console),
            Mount("/static", StaticFiles(directory=STATIC)),
        ],
        exception_handlers={ProblemError: _problem, HTTPException: _http_error, Exception: _bug},
    )
    return Guard(app, access)


async def _openapi(_: Request) -> Response:
    return JSONResponse(document())


async def _console(_: Request) -> Response:
    return FileResponse(STATIC / "index.html")


async def _tell(socket: WebSocket, listener: Listener) -> None:
    """Send events while the page is there; what it says is read and left alone."""
    gone = asyncio.create_task(_until_gone(socket))
    try:
        while not gone.done():
            taken = asyncio.create_task(listener.take())
            await asyncio.wait((taken, gone), return_when=asyncio.FIRST_COMPLETED)
            if not taken.done():
                taken.cancel()
                break
            for event in taken.result():
                await socket.send_json(event)
    except WebSocketDisconnect:
        pass  # it went while we told it something
    finally:
        gone.cancel()


async def _until_gone(socket: WebSocket) -> None:
    with contextlib.suppress(WebSocketDisconnect):
        while True:
            await socket.receive_text()


async def _problem(_: Request, problem: Exception) -> Response:
    assert isinstance(problem, ProblemError)
    return problem.response()


async def _http_error(_: Request, error: Exception) -> Response:
    """What Starlette itself refuses: no such page, or not by that method."""
    assert isinstance(error, HTTPException)
    response = ProblemError(error.status_code, str(error.detail)).response()
    response.headers.update(error.headers or {})
    return response


async def _bug(request: Request, error: Exception) -> Response:
    log.error("%s %s failed", request.method, request.url.path, exc_info=error)
    return ProblemError(500, "the reason is in the gateway's log").response()


def _id(request: Request) -> dict[str, Any]:
    return {"id": number_in(request, "id")}
