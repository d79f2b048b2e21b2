"""Pictures of a room on a CPU: ray casting under light that was measured beforehand."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32, UInt16
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.light.antialias import around_corners, blended, edge_corners
from sceneq_tools.room.light.corner_tables import corner_tables
from sceneq_tools.room.light.highlights import lamps
from sceneq_tools.room.light.light_mesh import LightMesh, light_mesh
from sceneq_tools.room.light.lit_room import LitRoom, lit, relit
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.light.shading import Shader
from sceneq_tools.room.light.stage import Stage
from sceneq_tools.room.light.surfaces import TextureStore
from sceneq_tools.room.light.tone import auto_exposure, tone_mapped
from sceneq_tools.room.light.tracer import Traced, Tracer
from sceneq_tools.room.mesh import Mesh
from sceneq_tools.room.rendering import Rendering
from sceneq_tools.room.room import Room

BRIGHTEST = (
    12.0  # a pixel is the mean of its rays; one that meets a lamp must not outweigh the rest
)
EYE_HEIGHT_M = 1.5
GLANCES = 4000  # rays from each place that the exposure is measured from


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A consistent state of the room to render: threads that use an old one are not disturbed.

    Attributes:
        thing_id, surface: uint16, int32 (F + 1,) by face: its thing, and a number for its thing
            and material; the last row is for no face.
    """

    lit: LitRoom
    tracer: Tracer
    thing_id: UInt16
    surface: Int32


class Renderer:
    """Renders a room from anywhere; the same room, pose and camera give the same bytes.

    Light is measured when it is made (seconds) and, after an edit, only where it may have changed.
    ``render`` may be called from several threads at once, also while ``update`` runs.
    """

    def __init__(self, room: Room, quality: Quality | None = None) -> None:
        """Measure the light of ``room`` and an exposure that is kept from then on."""
        self.quality = quality or Quality()
        self._threads = ThreadPoolExecutor(self.quality.threads, "shade")
        self._textures = TextureStore(self.quality.texture_px)
        self._meshes: dict[int, tuple[Mesh, LightMesh]] = {}
        self._view = self._viewed(lit(room, self._prepared(room), self.quality))
        self.exposure = self._metered()

    @property
    def room(self) -> Room:
        """The room as it is rendered now."""
        return self._view.lit.room

    def update(self, room: Room) -> None:
        """Show ``room`` from now on: what changed and what lies near it is lit anew."""
        self._view = self._viewed(relit(self._view.lit, room, self._prepared(room), self.quality))

    def render(self, T_world_camera: Float64, camera: Camera) -> Rendering:
        """Return what a perfect camera sees.

        Args:
            T_world_camera: (4, 4) pose, OpenCV axes (x right, y down, z forward), metres.
            camera: intrinsics and size of the picture.
        """
        view, (width, height) = self._view, camera.size
        columns, rows = np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64)
        traced = _trace(view.tracer, T_world_camera, camera, columns, rows[:, None])
        radiance = self._smoothed(view, T_world_camera, camera, traced)
        return Rendering(
            tone_mapped(radiance, self.exposure),
            traced.distance.reshape(height, width),
            view.thing_id.take(traced.face, mode="wrap").reshape(height, width),
            traced.cosine.reshape(height, width),
        )

    def _smoothed(
        self, view: View, T_world_camera: Float64, camera: Camera, traced: Traced
    ) -> Float32:
        """Return the radiances (H, W, 3), with further rays where surfaces meet."""
        width, height = camera.size
        brightest, count = np.float32(BRIGHTEST / self.exposure), self.quality.edge_rays
        radiance = np.minimum(traced.radiance, brightest).reshape(height, width, 3)
        if not count:
            return radiance
        corners = edge_corners(
            radiance * np.float32(self.exposure),
            view.surface.take(traced.face, mode="wrap").reshape(height, width),
            traced.distance.reshape(height, width),
            _slope_per_pixel(traced, camera).reshape(height, width),
        )
        x, y = around_corners(corners, count).reshape(-1, 2).T
        more = np.minimum(
            _trace(view.tracer, T_world_camera, camera, x, y).radiance, brightest
        ).reshape(count, -1, 3)
        return blended(radiance, corners, more.mean(axis=0).astype(np.float32, copy=False))

    def _viewed(self, room: LitRoom) -> View:
        shader = Shader(
            corner_tables(room.stage, room.place_light),
            self._textures.surfaces(list(room.stage.materials)),
            lamps(room.room.lights),
        )
        thing_id = np.append(room.stage.thing_id, np.uint16(0))
        return View(
            room, Tracer(room.raycaster, shader, self._threads), thing_id, _surfaces(room.stage)
        )

    def _prepared(self, room: Room) -> list[LightMesh]:
        """Prepare meshes that are new, and forget those that are used no more."""
        meshes = {id(thing.mesh): thing.mesh for thing in room.things}
        new = [mesh for key, mesh in meshes.items() if key not in self._meshes]
        made = self._threads.map(lambda mesh: light_mesh(mesh, self.quality.cell_m), new)
        fresh = {id(mesh): (mesh, one) for mesh, one in zip(new, made, strict=True)}
        self._meshes = {key: fresh.get(key) or self._meshes[key] for key in meshes}
        return [self._meshes[id(thing.mesh)][1] for thing in room.things]

    def _metered(self) -> float:
        """Look around from five places at eye height."""
        width, depth, _ = self.room.size_m
        places = [(0.5, 0.5), (0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)]
        seen = []
        for across, along in places:
            eye = np.array([across * width, along * depth, EYE_HEIGHT_M], np.float32)
            traced = self._view.tracer.trace(eye, _glances(), pixel=0.002)
            seen.append(traced.radiance[traced.face >= 0])
        return auto_exposure(np.concatenate(seen))


def _trace(
    tracer: Tracer, T_world_camera: Float64, camera: Camera, x: Float64, y: Float64
) -> Traced:
    """Trace through pixel positions; x (W,) and y (H, 1) make a grid, (N,) and (N,) a list.

    A ray's length is such that its distance is z-depth.
    """
    K = camera.K
    right, down, ahead = T_world_camera[:3, :3].T.astype(np.float32)
    across = ((x - K[0, 2]) / K[0, 0]).astype(np.float32)[..., None] * right
    along = ((y - K[1, 2]) / K[1, 1]).astype(np.float32)[..., None] * down + ahead
    origin = T_world_camera[:3, 3].astype(np.float32)
    return tracer.trace(origin, (across + along).reshape(-1, 3), pixel=1 / float(K[0, 0]))


def _surfaces(whole: Stage) -> Int32:
    """Number faces by thing and material, and add -1 for no face."""
    number = whole.thing_id.astype(np.int32) * np.int32(len(whole.materials)) + whole.material
    return np.append(number, np.int32(-1))


def _slope_per_pixel(traced: Traced, camera: Camera) -> Float32:
    """Return how much a smooth surface's depth may change to the next pixel, metres."""
    steepest = np.maximum(traced.cosine, np.float32(0.05))
    return (traced.distance / (float(camera.K[0, 0]) * steepest)).astype(np.float32)


def _glances() -> Float32:
    """Directions of equal share around the horizon, up to 25 degrees above and 45 below."""
    k = np.arange(GLANCES)
    up = np.sin(np.deg2rad(-45 + 70 * (k + 0.5) / GLANCES))
    angle = k * np.pi * (3 - np.sqrt(5))
    level = np.sqrt(1 - up**2)
    return np.column_stack([level * np.cos(angle), level * np.sin(angle), up]).astype(np.float32)
