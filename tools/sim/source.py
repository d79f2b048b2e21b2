"""Source kind ``sim``: a hand-held camera that walks through a furnished room, live."""

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from sceneq_core.ingest.source import Camera, RawFrame, RefusedError, Skipped
from sceneq_tools.room.camera.lookout import Lookout
from sceneq_tools.room.camera.patrol import Patrol
from sceneq_tools.room.camera.sensor import measure
from sceneq_tools.room.layout.compose import compose
from sceneq_tools.room.library import Library
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.light.renderer import Renderer
from sceneq_tools.room.models.libraries import open_library
from sceneq_tools.room.models.shapes import ParametricLibrary
from sceneq_tools.room.room import KINDS, Room
from sceneq_tools.sim.names import find, movable
from sceneq_tools.sim.studio import Shot, Studio, perfect
from sceneq_tools.sim.world import Json, World, described, need

log = logging.getLogger(__name__)

AHEAD_S = 0.3
"""So long before a frame is due its pose is known, and its picture may be begun."""
FOCAL = 525.0 / 640.0
"""Focal length in image widths: the first consumer depth cameras, 62.7 degrees across."""
LOOK_AROUND_S = 10.0
"""After a change the camera has to find out from where things are seen; longer it is not waited."""
SHAPES = "shapes"
LIGHTS = {
    "quick": Quality(
        shadow_rays=4, gather_rays=8, bounces=1, cell_m=0.1, texture_px=512, edge_rays=1
    ),
    "fine": Quality(),
}
"""Quick light takes a third of the time to set up, a fifth after a change; shadows are coarser."""
DAY_S = 86_400


@dataclass(frozen=True, slots=True)
class SimParams:
    """A room, the camera in it, and how fast time passes there.

    ``rate_hz`` frames a second of the room's time, as ingest plays them; ``noise``: of a depth
    sensor, else the images are perfect; ``frames`` 0 = for ever; ``models``: folder of furniture,
    ``shapes`` for our own simple ones, empty for the best there is; ``light`` quick or fine.
    """

    room: str = "office"
    seed: int = 3
    rate_hz: float = 30.0
    width: int = 640
    height: int = 480
    noise: bool = True
    frames: int = 0
    models: str = ""
    light: str = "quick"
    use_poses: bool = True

    def __post_init__(self) -> None:
        if self.room not in KINDS:
            raise ValueError(f"room: expected one of {', '.join(KINDS)}, got {self.room!r}")
        if self.light not in LIGHTS:
            raise ValueError(f"light: expected one of {', '.join(LIGHTS)}, got {self.light!r}")
        for name in ("rate_hz", "width", "height"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name}: expected more than 0, got {getattr(self, name)}")
        for name in ("seed", "frames"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name}: expected 0 or more, got {getattr(self, name)}")


class SimSource:
    """Exact poses, images on demand, and a room that ``control`` changes."""

    Params: ClassVar[type] = SimParams

    def __init__(self, params: SimParams) -> None:
        """Furnish the room and light it, which takes seconds; ``ValueError`` when that fails."""
        self._params = params
        self.name = f"{params.room}_{params.seed}"
        self.color_camera = self.depth_camera = _camera(params.width, params.height)
        self.T_color_depth = np.eye(4)
        self.has_poses = params.use_poses
        began_s = time.monotonic()
        library = _library(params.models)
        room = compose(params.room, params.seed, library)
        log.info("%s: %d things of %s; lighting it", self.name, len(room.things), library.name)
        sensor = measure if params.noise else perfect
        renderer = Renderer(room, LIGHTS[params.light])
        self._studio = Studio(renderer, sensor, self.color_camera, params.seed)
        self._lookout = Lookout(room, params.seed)
        self._world = World(room, library, self._change)
        self._looking: threading.Thread | None = None
        self._patrol = self._new_patrol()
        self._walk = self._endless()
        log.info("%s: ready after %.1f s", self.name, time.monotonic() - began_s)

    def frames(self) -> Iterator[RawFrame | Skipped]:
        """Yield ``frames`` of them, the same every time; or, for ever, go on from the last one."""
        return self._bounded() if self._params.frames else self._walk

    def control(self, verb: str, arguments: Mapping[str, str]) -> dict[str, Any]:
        """List, move, remove or add things, or look at one: ``sceneq sim --help``.

        Raises:
            RefusedError: an unknown verb, or something that this room does not allow.
        """
        verbs: dict[str, Callable[[Mapping[str, str]], Json]] = {
            "list": lambda _: self._listed(),
            "move": self._world.move,
            "remove": self._world.remove,
            "add": self._world.add,
            "look": self._look,
        }
        if verb not in verbs:
            raise RefusedError(f"a simulation knows no '{verb}'", f"known: {', '.join(verbs)}")
        return verbs[verb](arguments)

    def _bounded(self) -> Iterator[RawFrame]:
        self._patrol = self._new_patrol()
        return islice(self._play(0, 0), self._params.frames)

    def _new_patrol(self) -> Patrol:
        return Patrol(self._lookout, self._params.rate_hz, self._params.seed)

    def _endless(self) -> Iterator[RawFrame]:
        """Number frames by the time of day: a simulation that starts again reuses no number."""
        now_ns = time.time_ns()
        seq = int(now_ns / 1e9 % DAY_S * self._params.rate_hz)
        yield from self._play(seq, now_ns)

    def _play(self, first_seq: int, start_ns: int) -> Iterator[RawFrame]:
        ahead = max(1, round(AHEAD_S * self._params.rate_hz))
        due: deque[RawFrame] = deque()
        for k, T_world_camera in enumerate(self._patrol.poses()):
            shot = self._studio.shot(first_seq + k, T_world_camera)
            stamp_ns = start_ns + round(k * 1e9 / self._params.rate_hz)
            due.append(self._frame(shot, stamp_ns))
            if len(due) > ahead:
                yield due.popleft()

    def _frame(self, shot: Shot, stamp_ns: int) -> RawFrame:
        return RawFrame(
            seq=shot.seq,
            stamp_ns=stamp_ns,
            T_world_camera=shot.T_world_camera if self.has_poses else None,
            read_rgb=shot.read_rgb,
            read_depth_mm=shot.read_depth_mm,
        )

    def _change(self, room: Room) -> None:
        """Show the changed room from the next picture on; where to look is found out beside."""
        self._studio.change(room)
        self._looking = threading.Thread(target=self._look_around, args=(room,), daemon=True)
        self._looking.start()

    def _look_around(self, room: Room) -> None:
        try:
            self._lookout = self._patrol.lookout = Lookout(room, self._params.seed)
        except ValueError as error:
            log.warning("%s: the camera keeps to its old ways: %s", self.name, error)

    def _listed(self) -> Json:
        """Return the things, and how many pixels the newest picture shows of each."""
        seq, pixels = self._studio.newest
        listed = self._world.listed()
        for thing in listed["things"]:
            thing["pixels"] = pixels.get(thing["id"], 0)
        return {**listed, "frame_seq": seq}

    def _look(self, arguments: Mapping[str, str]) -> Json:
        """Make the camera go to a thing next."""
        room = self._world.room
        thing = find(room, need(arguments, "thing"), movable(room))
        if self._looking is not None:
            self._looking.join(LOOK_AROUND_S)
        self._patrol.attend(thing.id)
        return {"verb": "look", **described(room, thing)}


def _camera(width: int, height: int) -> Camera:
    f, cx, cy = FOCAL * width, (width - 1) / 2, (height - 1) / 2
    return Camera(np.array([[f, 0.0, cx], [0.0, f, cy], [0.0, 0.0, 1.0]]), (width, height))


def _library(models: str) -> Library:
    if models == SHAPES:
        return ParametricLibrary()
    return open_library(Path(models) if models else None)
