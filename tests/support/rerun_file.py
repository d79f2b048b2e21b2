"""What a Rerun recording holds."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Contents:
    """Everything logged: entity -> component -> values in the order of logging."""

    entities: dict[str, dict[str, list[Any]]]
    timelines: tuple[str, ...]

    def texts(self, entity: str) -> list[str]:
        """Return all texts logged to an entity: labels, names and documents."""
        return [
            text
            for values in self.entities[entity].values()
            for row in values
            for text in row
            if isinstance(text, str)
        ]

    def scalars(self, entity: str) -> list[list[float]]:
        """Return the scalars logged to an entity."""
        return self.entities[entity]["Scalars:scalars"]


def contents(path: Path) -> Contents:
    """Read a recording."""
    from rerun.chunk import RrdReader

    entities: dict[str, dict[str, list[Any]]] = {}
    timelines: set[str] = set()
    for chunk in RrdReader(path).stream():
        timelines.update(chunk.timeline_names)
        logged = entities.setdefault(str(chunk.entity_path), {})
        batch = chunk.to_record_batch()
        for name, column in zip(batch.schema.names, batch.columns, strict=True):
            if ":" in name:  # a component, not a time
                logged.setdefault(name, []).extend(column.to_pylist())
    return Contents(entities, tuple(sorted(timelines)))
