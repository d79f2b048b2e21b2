"""``sceneq mcp``: the scene as tools of a language model's agent."""

from typing import Annotated

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint


def run(
    scene: Annotated[str | None, typer.Option(help="Default: the only one that answers.")] = None,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Serve the Model Context Protocol on stdin and stdout; the agent's host starts this."""
    from sceneq_client import SceneError, SceneQ
    from sceneq_client.agent_tools import agent_tools
    from sceneq_tools.errors import UserError

    try:
        with SceneQ(connect, scene) as client:
            agent_tools(client).run("stdio")
    except SceneError as error:
        raise UserError(str(error)) from error
