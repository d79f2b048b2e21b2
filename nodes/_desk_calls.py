"""What ingest asks of the one who keeps the map: which visit this is, which places there are."""

import logging
from typing import Any

from sceneq_core.places.place import Place
from sceneq_core.places.relocaliser import Relocation
from sceneq_core.places.visit import Visit
from sceneq_nodes._bus import Bus, QueryError
from sceneq_nodes._fetch import Fetch
from sceneq_nodes._held_files import Caller
from sceneq_nodes._place_message import place_from_message
from sceneq_nodes._visit_json import visit_from_json
from sceneq_nodes._wire import from_bytes, json_bytes
from sceneq_schemas.errors import DecodeError
from sceneq_schemas.topics import PLACES, VISIT

log = logging.getLogger(__name__)

TRIES = 3


class DeskCalls:
    """Asks the visit desk of mapping; what fails is counted and told."""

    def __init__(self, bus: Bus, scene: str) -> None:
        self._bus = bus
        self._scene = scene
        self._have = ""

    def register(self, caller: Caller, start: str) -> Visit | None:
        """Return the visit that ``caller`` is, ``None`` when nobody tells."""
        return self._ask(
            {
                "robot": caller.robot,
                "seq": caller.seq,
                "stamp_ns": caller.stamp_ns,
                "fingerprint": caller.fingerprint,
                "start": start,
            }
        )

    def settle(self, visit: int, found: Relocation) -> bool:
        """Tell where a visit's frame of reference lies; return whether that was taken."""
        T_world_odom = found.T_world_odom.tolist()
        asked = {"visit": visit, "T_world_odom": T_world_odom, "evidence": _words(found)}
        if self._ask(asked) is None:
            return False
        log.info("visit %s found its place: %s", visit, _words(found))
        self._bus.count("relocalised")
        return True

    def places(self) -> list[Place] | None:
        """Return the places of the map, ``None`` when they are those of the last time."""
        fetch = Fetch(self._bus, PLACES, {"have": self._have}, scene=self._scene)
        try:
            while not fetch.done:
                fetch.step()
            if fetch.message is None:
                return None
            found = [place_from_message(place) for place in fetch.message.places]
        except (QueryError, DecodeError) as error:
            self._bus.count("places_failed")
            log.warning("places: %s", error)
            return None
        self._have = f"{fetch.message.epoch}:{fetch.message.seq}"
        return found

    def _ask(self, asked: dict[str, Any]) -> Visit | None:
        for _ in range(TRIES):
            try:
                replies = self._bus.ask(VISIT, payload=json_bytes(asked), scene=self._scene)
                if replies:
                    return visit_from_json(from_bytes(VISIT, replies[-1].payload))
            except (QueryError, DecodeError, ValueError) as error:
                self._bus.count("visit_failed")
                log.warning("mapping did not take the visit: %s", error)
        return None


def _words(found: Relocation) -> str:
    return (
        f"{found.keyframes} keyframes recognised at {found.places} places, {found.features} "
        f"features, trust {found.trust:.2f}, spread {100 * found.spread_m:.1f} cm"
    )
