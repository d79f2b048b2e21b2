"""The scene by HTTP and WebSocket, for browsers and programs that do not speak Zenoh.

Reads   map deltas of the scene, health of every node.
Asks    the front door what the web asks it, views for pictures.
Writes  nothing on the bus; pages and events to whoever may ask (localhost, unless told otherwise).
Rate    as asked; events as they happen, the nodes' health once a second.
Bad     what the web asks wrongly is answered with a problem (RFC 9457) and counted by the front
        door; a delta that contradicts the map counts as ``map_delta_bad``; a page that is slower
        than the events loses the oldest and is told how many.
"""

import logging
import os
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from sceneq_nodes._bus import Bus, Context, Received
from sceneq_nodes._followed_map import FollowedMap
from sceneq_nodes.web.app import Pages, application
from sceneq_nodes.web.cloud import cloud_bytes
from sceneq_nodes.web.desk import Desk
from sceneq_nodes.web.events import Hub
from sceneq_nodes.web.guard import LOOPBACK, Access
from sceneq_nodes.web.server import TlsParams, WebServer
from sceneq_schemas import topics
from sceneq_schemas.map import MapDelta

log = logging.getLogger(__name__)

TOKEN_VARIABLE = "SCENEQ_GATEWAY_TOKEN"
HEALTH_DEPTH = 64


@dataclass(frozen=True, slots=True)
class GatewayParams:
    """Where to listen and for whom.

    Another ``host`` than this machine's own needs a token in the environment (SCENEQ_GATEWAY_TOKEN)
    or ``tls`` with ``client_ca``; ``hosts`` are the names by which pages may then be asked for.
    Where ``port`` is taken, by another graph say, one of the next 19 is.
    ``timeout_s``: how long a question may take. ``max_points`` of the map are drawn.
    """

    host: str = "127.0.0.1"
    port: int = 8480
    hosts: tuple[str, ...] = ()
    tls: TlsParams | None = None
    timeout_s: float = 30.0
    max_points: int = 200_000
    max_listeners: int = 32
    max_connections: int = 128
    max_body_bytes: int = 64 * 1024

    def __post_init__(self) -> None:
        if not 0 <= self.port < 65536:
            raise ValueError(f"port: {self.port} is not in 0..65535")
        for name in ("timeout_s", "max_points", "max_listeners", "max_connections"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name}: must be more than 0, got {getattr(self, name)}")

    @property
    def is_local(self) -> bool:
        """Whether only this machine can ask."""
        return self.host in ("127.0.0.1", "::1", "localhost")

    def access(self, token: str) -> Access:
        """Return who may ask; raise ``ValueError`` when that would be anybody on the network."""
        if not (self.is_local or token or (self.tls and self.tls.client_ca)):
            raise ValueError(
                f"host: {self.host} lets others in: set {TOKEN_VARIABLE}, or tls with client_ca"
            )
        return Access(token, LOOPBACK | {self.host, *self.hosts}, self.max_body_bytes)


class Gateway:
    """Follows one scene and answers the web."""

    Params: ClassVar[type] = GatewayParams
    idle_s: ClassVar[float] = 0.5

    def __init__(self, params: GatewayParams, context: Context) -> None:
        self._params = params
        self._context = context
        self._revision = "0:0"
        self._lock = threading.Lock()
        self._hub = Hub(params.max_listeners)

    def open(self, bus: Bus) -> None:
        """Listen on both sides; raise ``ValueError`` when the port cannot be had."""
        self._bus, params = bus, self._params
        self._map = FollowedMap(bus, self._context.scene, self._tell, self._lock)
        desk = Desk(bus, self._context.scene, params.timeout_s)
        app = application(
            Pages(desk, self._hub, self._cloud), params.access(os.environ.get(TOKEN_VARIABLE, ""))
        )
        self._server = WebServer(app, params.host, params.port, params.max_connections, params.tls)
        port = self._server.open()
        bus.subscribe(topics.HEALTH, depth=HEALTH_DEPTH)
        self._map.open()
        scheme = "https" if params.tls else "http"
        log.warning("open %s://%s:%d in a browser", scheme, params.host, port)
        bus.report(port=port)

    def step(self, received: Received | None) -> None:
        """Tell the pages what happened."""
        if received is None:
            self._map.tick()
        elif received.topic is topics.MAP_DELTA:
            self._map.offer(received.message)
        else:
            self._hub.tell({"type": "health", "node": received.ids["node"], **received.message})
        self._bus.report(listeners=self._hub.count)

    def close(self) -> None:
        """Stop answering the web."""
        self._server.close()

    def _tell(self, delta: MapDelta) -> None:
        self._revision = f"{delta.epoch}:{delta.seq}"
        for event in delta.events:
            self._hub.tell({"type": "change", **_change(event)})
        self._hub.tell({"type": "map", "epoch": delta.epoch, "seq": delta.seq})

    def _cloud(self) -> tuple[str, bytes]:
        with self._lock:
            return self._revision, cloud_bytes(self._map.replica, self._params.max_points)


def _change(event: Any) -> Mapping[str, Any]:
    names = ("kind", "instance_id", "other_id", "stamp_ns")
    return {name: getattr(event, name) for name in names}
