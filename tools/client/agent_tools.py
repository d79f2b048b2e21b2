"""The scene as tools of a language model's agent, by the Model Context Protocol.

https://modelcontextprotocol.io: the agent's host starts ``sceneq mcp`` and calls these. Every tool
answers with JSON; what goes wrong is told to the model as the tool's error, so that it can ask
otherwise.
"""

import inspect
from collections.abc import Callable
from functools import wraps
from importlib.metadata import version
from typing import Any, TypeVar

from mcp.server.mcpserver import Image, MCPServer
from mcp.server.mcpserver.exceptions import ToolError

from sceneq_client.answer import Answer, Instance
from sceneq_client.errors import SceneError
from sceneq_client.scene_q import SceneQ

R = TypeVar("R")
INSTRUCTIONS = """\
Answers questions about the room a robot is in, from its live 3D map. Coordinates are metres in the
map's frame. `status` of an answer is found, ambiguous (ask which one is meant) or not_found; `p` is
a calibrated probability. Look at the `picture` before you rely on an uncertain answer.
"""
MAX_LISTED = 200


def agent_tools(scene: SceneQ) -> MCPServer[Any]:
    """Return the server of the tools for ``scene``."""
    server: MCPServer[Any] = MCPServer(
        "sceneq", instructions=INSTRUCTIONS, version=version("sceneq"), log_level="WARNING"
    )
    for tool in (_ask, _list_things, _name_of, _picture, _scene_status):
        server.tool(name=tool.__name__.removeprefix("_"))(_bound(tool, scene))
    return server


def _ask(scene: SceneQ, question: str, k: int = 5) -> dict[str, Any]:
    """Find things and answer questions: "the red mug on the table", "how many chairs",
    "what is on the desk", "where is the lamp", "is there a sink", "when did you last see the keys".
    """
    answer = scene.ask(question, k=k)
    facts = ("exists", "count", "where", "last_seen", "missing", "nearest_miss")
    said = {name: answer.raw[name] for name in facts if name in answer.raw}
    return {**_told(answer), **said, "things": [_thing(one) for one in answer.instances]}


def _list_things(scene: SceneQ) -> list[dict[str, Any]]:
    """List what is in the map, without floor, walls and ceiling."""
    things = (one for one in scene.instances() if one.role == "object")
    return [_thing(one) for one, _ in zip(things, range(MAX_LISTED), strict=False)]


def _name_of(scene: SceneQ, thing_id: int, choices: list[str] | None = None) -> dict[str, Any]:
    """Say what one thing is, of your own choices of names if you give them."""
    naming = scene.label(thing_id, choices)
    names = [{"name": one.label, "p": one.p, "source": one.source} for one in naming.names]
    return {"status": naming.status, "names": names}


def _picture(scene: SceneQ, thing_id: int) -> Image:
    """Show the camera image in which a thing is seen best."""
    views = scene.label(thing_id).instance.views
    if not views:
        raise ToolError(f"thing {thing_id} has no picture yet")
    return Image(data=scene.picture(views[0]), format="jpeg")


def _scene_status(scene: SceneQ) -> dict[str, Any]:
    """Say how the map and the processes behind it are."""
    return scene.status()


def _told(answer: Answer) -> dict[str, Any]:
    return {
        "status": answer.status,
        "said": answer.said,
        "route": answer.route,
        "reason": answer.reason,
    }


def _thing(one: Instance) -> dict[str, Any]:
    return {
        "id": one.id,
        "label": one.label,
        "p": one.p,
        "state": one.state,
        "centre_m": one.centre_world,
        "size_m": [round(edge, 3) for edge in one.box.size_m],
        "last_seen_ns": one.last_seen_ns,
    }


def _bound(tool: Callable[..., R], scene: SceneQ) -> Callable[..., R]:
    """Return ``tool`` without its first parameter, which the model must not see."""

    @wraps(tool)
    def call(**arguments: Any) -> R:
        try:
            return tool(scene, **arguments)
        except SceneError as error:
            raise ToolError(str(error)) from error

    signature = inspect.signature(tool)
    call.__signature__ = signature.replace(  # type: ignore[attr-defined]
        parameters=list(signature.parameters.values())[1:]
    )
    call.__annotations__.pop("scene")
    return call
