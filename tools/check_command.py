"""``sceneq check``: is this graph file right?"""

from pathlib import Path
from typing import Annotated

import typer


def run(
    graph: Annotated[
        Path | None, typer.Argument(metavar="GRAPH.YAML", help="Default: as for `sceneq up`.")
    ] = None,
) -> None:
    """Check a graph file: every key, node kind and parameter, with line numbers.

    Of a graph for several machines, tell what crosses between them.
    """
    from sceneq_tools.crossing import crossings
    from sceneq_tools.graph import default_path, load
    from sceneq_tools.graph_check import check_nodes

    path = graph or default_path()
    loaded, document = load(path)
    check_nodes(loaded, document)
    names = " ".join(node.id for node in loaded.nodes)
    typer.echo(f"{path}: {len(loaded.nodes)} nodes are right: {names}")
    for one in crossings(loaded):
        typer.echo(f"{one.source} -> {one.target}: {one.stream}, up to {one.mbit_s:.1f} Mbit/s")
