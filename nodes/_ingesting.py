"""A source with everything that turns its frames into keyframes, from three specifications."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from sceneq_core.ingest.ingestor import Ingestor
from sceneq_core.ingest.source import Source
from sceneq_nodes._backends import build

Spec = dict[str, Any]


@dataclass(frozen=True, slots=True)
class IngestSpecs:
    """``{kind: ..., ...}`` of the source, of the choice of keyframes and of the odometry.

    The odometry is built only when the source has no poses.
    """

    source: Spec
    keyframes: Spec = field(default_factory=lambda: {"kind": "every", "every": 10})
    odometry: Spec = field(default_factory=lambda: {"kind": "kiss_icp"})


def open_ingestor(specs: IngestSpecs) -> tuple[Source, Ingestor]:
    """Return what ingest and ``sceneq map`` both read from; ``ValueError`` on bad input."""
    source: Source = _build("source", specs.source)
    keyframes = _build("keyframes", specs.keyframes)
    odometry = None if source.has_poses else _build("odometry", specs.odometry)
    return source, Ingestor(source, keyframes, odometry)


def _build(seam: str, spec: Mapping[str, Any]) -> Any:
    return build(seam, spec, (seam,))
