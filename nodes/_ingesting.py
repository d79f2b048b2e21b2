"""A source with everything that turns its frames into keyframes, from three specifications."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from sceneq_core.ingest.ingestor import Ingestor
from sceneq_core.ingest.pose_graph import PoseGraph, PoseGraphParams
from sceneq_core.ingest.source import Source
from sceneq_nodes._backends import build

Spec = dict[str, Any]


@dataclass(frozen=True, slots=True)
class IngestSpecs:
    """``{kind: ..., ...}`` of the source, of the choice of keyframes and of the odometry.

    The odometry, and the ``pose_graph`` that corrects it, are built only when the source has no
    poses.
    """

    source: Spec
    keyframes: Spec = field(default_factory=lambda: {"kind": "interval"})
    odometry: Spec = field(default_factory=lambda: {"kind": "depth_icp"})
    pose_graph: PoseGraphParams = field(default_factory=PoseGraphParams)


def open_source(specs: IngestSpecs) -> Source:
    """Return the source alone; ``ValueError`` when there is no such one or it cannot be played."""
    source: Source = _build("source", specs.source)
    return source


def new_ingestor(source: Source, specs: IngestSpecs) -> Ingestor:
    """Return what takes the frames of ``source`` from the first one on."""
    keyframes = _build("keyframes", specs.keyframes)
    if source.has_poses:
        return Ingestor(source, keyframes)
    odometry = _build("odometry", specs.odometry)
    return Ingestor(source, keyframes, odometry, PoseGraph(specs.pose_graph))


def _build(seam: str, spec: Mapping[str, Any]) -> Any:
    return build(seam, spec, (seam,))
