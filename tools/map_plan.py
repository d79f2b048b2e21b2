"""What runs when a recording becomes a map in one process."""

from pathlib import Path

from sceneq_tools.graph import Override, default_path, load
from sceneq_tools.graph_check import check_nodes
from sceneq_tools.graph_plan import Plan, plan
from sceneq_tools.up_command import source_overrides


def map_plan(
    source: Path,
    graph: Path | None = None,
    scene: str | None = None,
    step: int | None = None,
    no_poses: bool = False,
    segmenter: str | None = None,
    proposals: Path | None = None,
) -> Plan:
    """Return the nodes that make a map of ``source``; ``UserError`` when they cannot."""
    # Rate 0: the next frame is read when the last one is in the map.
    overrides = source_overrides(source, scene, 0.0, None, False, no_poses, segmenter)
    if step is not None:
        every = {"kind": "every", "every": step}
        overrides.append(Override("ingest", ("keyframes",), every, "--step"))
    if proposals is not None:
        masks = {"kind": "file", "path": str(proposals.resolve())}
        overrides.append(Override("mapping", ("proposals",), masks, "--proposals"))
    loaded, document = load(graph or default_path(), overrides)
    check_nodes(loaded, document)
    return plan(loaded, document, "local")
