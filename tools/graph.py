"""The graph: which nodes run on which machine with which parameters, read from ``graph.yaml``."""

from collections.abc import Iterable
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from sceneq_nodes._params import did_you_mean
from sceneq_schemas.topics import ID
from sceneq_tools.graph_document import Document, KeyPath
from sceneq_tools.graph_problem import ABSENT, GraphError, Problem

Id = Annotated[str, Field(pattern=f"^{ID.pattern}$")]
Endpoint = Annotated[str, Field(pattern=r"^[a-z]+/.+$")]
Seconds = Annotated[float, Field(gt=0)]
ROUTER = "router"
DEFAULT_ENDPOINT = "tcp/127.0.0.1:7447"


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class Router(_Strict):
    """Where a machine's router listens and which other routers it joins."""

    listen: Annotated[list[Endpoint], Field(min_length=1)] = [DEFAULT_ENDPOINT]
    connect: list[Endpoint] = []


class Machine(_Strict):
    """A machine that nodes are deployed to; ``uplink_mbit_s``: what it can send to the others."""

    router: Router = Router()
    uplink_mbit_s: Annotated[float, Field(gt=0)] | None = None


class WatchdogLimits(_Strict):
    """When a node counts as hung: seconds of silence, seconds inside one step."""

    silent_s: Seconds = 3.0
    busy_s: Seconds = 60.0


class Deploy(_Strict):
    """The machine a node runs on."""

    machine: Id = "local"


class GraphNode(_Strict):
    """One process of the graph."""

    id: Id
    kind: str = ""
    params: dict[str, Any] = {}
    deploy: Deploy = Deploy()
    restart_policy: Literal["on-failure", "always", "never"] = "on-failure"
    max_restarts: Annotated[int, Field(ge=0)] = 5

    @property
    def node_kind(self) -> str:
        """The node class; the id names it unless ``kind`` does."""
        return self.kind or self.id


class Graph(_Strict):
    """Everything ``sceneq up`` needs to know."""

    scene: Id | None = None
    robot: Id = "robot"
    sensor: Id = "camera"
    store: str | None = None
    log: Literal["text", "json"] = "text"
    secure: str | None = None
    router: Router = Router()
    machines: dict[Id, Machine] = {}
    watchdog: WatchdogLimits = WatchdogLimits()
    nodes: Annotated[list[GraphNode], Field(min_length=1)]


MODELS: dict[tuple[str, ...], type[BaseModel]] = {
    (): Graph,
    ("router",): Router,
    ("machines",): Machine,
    ("machines", "router"): Router,
    ("watchdog",): WatchdogLimits,
    ("nodes",): GraphNode,
    ("nodes", "deploy"): Deploy,
}


@dataclass(frozen=True, slots=True)
class Override:
    """A value that an option puts over every node of ``kind``, or over the graph if it is ''."""

    kind: str
    path: KeyPath
    value: Any
    option: str


def default_path() -> Path:
    """Return ``./graph.yaml`` if there is one, else the graph that comes with the package."""
    here = Path("graph.yaml")
    return here if here.is_file() else Path(str(files("sceneq_tools"))) / "graph.yaml"


def load(path: Path, overrides: Iterable[Override] = ()) -> tuple[Graph, Document]:
    """Return the graph in a file; node parameters are checked by ``graph_check``.

    Raises:
        GraphError: with every unknown key, missing key and wrong value.
    """
    document = Document(path)
    for override in overrides:
        _apply(document, override)
    try:
        graph = Graph.model_validate(document.values)
    except ValidationError as error:
        raise GraphError([_problem(document, e) for e in error.errors()]) from error
    if twins := _twins(document, graph):
        raise GraphError(twins)
    return graph, document


def shown_path(document: Document, path: KeyPath) -> str:
    """Return ``nodes.mapping.params.voxel_m`` for ``("nodes", 2, "params", "voxel_m")``."""
    parts = [str(part) for part in path]
    if len(path) > 1 and path[0] == "nodes":
        parts[1] = _node_id(document, path[1])
    return ".".join(parts)


def _node_id(document: Document, index: str | int) -> str:
    nodes = document.values.get("nodes")
    node = nodes[index] if isinstance(nodes, list) and isinstance(index, int) else None
    return str(node.get("id", index)) if isinstance(node, dict) else str(index)


def _apply(document: Document, override: Override) -> None:
    if not override.kind:
        document.override(override.path, override.value, override.option)
        return
    nodes = document.values.get("nodes")
    found = [
        i
        for i, node in enumerate(nodes if isinstance(nodes, list) else [])
        if isinstance(node, dict) and (node.get("kind") or node.get("id")) == override.kind
    ]
    if not found:
        raise GraphError(
            [Problem(override.option, "nodes", f"{document.name} has no node '{override.kind}'")]
        )
    for index in found:
        path = ("nodes", index, "params", *override.path)
        document.override(path, override.value, override.option)


def _problem(document: Document, error: Any) -> Problem:
    path: KeyPath = error["loc"]
    where, shown = document.where(path), shown_path(document, path)
    if error["type"] == "extra_forbidden":
        model = MODELS[_kinds(path[:-1])]
        hint = did_you_mean(str(path[-1]), set(model.model_fields))
        return Problem(where, shown, "unknown key", hint=hint)
    if error["type"] == "missing":
        return Problem(where, shown, "missing key", hint=f"add '{path[-1]}: ...'")
    return Problem(where, shown, error["msg"], error.get("input", ABSENT))


def _kinds(path: KeyPath) -> tuple[str, ...]:
    """Return the path without numbers and names: what sort of place it is."""
    named = ("machines",)
    return tuple(
        part
        for i, part in enumerate(path)
        if isinstance(part, str) and (i == 0 or path[i - 1] not in named)
    )


def _twins(document: Document, graph: Graph) -> list[Problem]:
    problems, seen = [], {ROUTER}
    for index, node in enumerate(graph.nodes):
        if node.id in seen:
            path: KeyPath = ("nodes", index, "id")
            message = "the router's own name" if node.id == ROUTER else "another node's id"
            problems.append(
                Problem(document.where(path), shown_path(document, path), message, node.id)
            )
        seen.add(node.id)
    return problems
