"""What a query sees: one immutable snapshot, from its arrival to its answer."""

import time
import uuid
from collections import Counter
from dataclasses import dataclass

from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.routing.unfamiliar import scene_familiarity
from sceneq_nodes._answer_json import Json, Stamp, map_json
from sceneq_nodes._bus import QueryError
from sceneq_nodes._calibration import NO_CALIBRATION
from sceneq_nodes._stopwatch import Stopwatch


@dataclass(frozen=True, slots=True)
class Look:
    """The newest snapshot and when its map arrived, on the clock of ``time.monotonic``.

    ``calibration`` names what its probabilities were calibrated by.
    """

    snapshot: SceneSnapshot
    map_arrived_s: float
    calibration: str = NO_CALIBRATION

    def row(self, instance_id: int, scene: str) -> int:
        """Return the row of an instance; raise ``QueryError`` when there is none."""
        row = self.snapshot.find(instance_id)
        if row is None:
            raise no_such(instance_id, scene)
        return row

    def stamp(self, scene: str, watch: Stopwatch) -> Stamp:
        """Return what the process adds to an answer."""
        return Stamp(
            scene=scene,
            query_id=uuid.uuid4().hex[:12],
            map_age_s=self._age_s(),
            took_ms=watch.total_ms(),
            stage_ms=watch.stage_ms,
            calibration=self.calibration,
        )

    def scene_json(self, scene: str) -> Json:
        """Return which map this is, how much is in it and how familiar it looks to the encoder."""
        snapshot = self.snapshot
        return {
            "scene": scene,
            "instances": snapshot.instance_count,
            "answerable": len(snapshot),
            "map": map_json(snapshot.revision, self._age_s()),
            "frame_seq": snapshot.revision.frame_seq,
            "calibration": self.calibration,
            "familiarity": round(scene_familiarity(snapshot.columns), 3),
        }

    def given(self, most: int) -> dict[str, int]:
        """Return the ``most`` given labels, the most frequent first, with their number."""
        counts = Counter(instance.label.name for instance in self.snapshot.instances)
        return dict(sorted(counts.items(), key=lambda item: (-item[1], item[0]))[:most])

    def _age_s(self) -> float:
        return time.monotonic() - self.map_arrived_s


def no_such(instance_id: int, scene: str) -> QueryError:
    """Return the error that an instance is not in the map."""
    hint = f"list them: sceneq/query/{scene}/instances?k=100"
    return QueryError("not_found", f"there is no such instance: {instance_id}", hint)
