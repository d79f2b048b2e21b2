"""``sceneq trace``: the way of a keyframe and of a question through the nodes."""

from typing import TYPE_CHECKING, Annotated

import typer

from sceneq_tools.ask_command import DEFAULT_ENDPOINT, Endpoint

if TYPE_CHECKING:
    from sceneq_nodes._client import Client

FRAME_COLUMNS = ("frame", "stage", "ms after the frame", "KiB")
TIMEOUT_S = 30.0
QUESTION_COLUMNS = ("question", "stage", "ms")


def run(
    question: Annotated[str, typer.Argument(help="A question to follow too.")] = "",
    frames: Annotated[int, typer.Option(min=0, help="How many keyframes to follow.")] = 3,
    patience: Annotated[
        float, typer.Option(min=0.1, metavar="S", help="How long to wait for them, seconds.")
    ] = 20.0,
    scene: Annotated[str | None, typer.Option(help="Of the question, if there are many.")] = None,
    connect: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Say when each node had done its part; exit code 1 when no keyframe came."""
    from sceneq_tools import scenes
    from sceneq_tools.errors import UserError
    from sceneq_tools.table import print_table
    from sceneq_tools.trace import trace_frames

    with scenes.connect(connect) as client:
        traces = trace_frames(client, frames, patience) if frames else []
        print_table(FRAME_COLUMNS, [row for trace in traces for row in trace.rows()])
        if question:
            print_table(QUESTION_COLUMNS, _question_rows(client, question, scene))
    if frames and not traces:
        raise UserError(f"no keyframe came within {patience:g} s (sceneq status says why)")


def _question_rows(client: "Client", question: str, scene: str | None) -> list[tuple[str, ...]]:
    """Return the stages that the answer tells, and what the way to routing and back took."""
    from sceneq_schemas.topics import QUERY_ASK
    from sceneq_tools import scenes

    named = scenes.need_scene(client, scene)
    asked = scenes.ask(client, QUERY_ASK, named, {"q": question}, TIMEOUT_S)
    told: dict[str, float] = asked.body["cost"]["ms"]
    took_ms = float(asked.body["took_ms"])
    rest = {
        "rest of routing": took_ms - sum(told.values()),
        "bus": asked.round_trip_ms - took_ms,
    }
    return [(question, stage, f"{ms:.2f}") for stage, ms in {**told, **rest}.items()]
