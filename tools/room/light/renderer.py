"""Pictures of a room on a CPU: ray casting under light that was measured beforehand."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from sceneq_core.arrays import Float32, Float64, Int32
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.light.antialias import edge_pixels, sub_pixels
from sceneq_tools.room.light.corner_tables import corner_tables
from sceneq_tools.room.light.highlights import lamps
from sceneq_tools.room.light.light_mesh import LightMesh, light_mesh
from sceneq_tools.room.light.lit_room import LitRoom, lit, relit
from sceneq_tools.room.light.quality import Quality
from sceneq_tools.room.light.shading import Shader
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
    """A consistent state of the room to render: threads that use an old one are not disturbed."""

    lit: LitRoom
    tracer: Tracer


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
        x, y = np.meshgrid(np.arange(width), np.arange(height))
        pixels = np.stack([x.ravel(), y.ravel()], axis=1).astype(np.float64)
        traced = _trace(view.tracer, T_world_camera, camera, pixels)
        seen = traced.face >= 0
        thing = np.where(seen, view.lit.stage.thing_id[traced.face], 0).astype(np.uint16)
        radiance = self._smoothed(view, T_world_camera, camera, pixels, traced)
        return Rendering(
            tone_mapped(radiance, self.exposure).reshape(height, width, 3),
            traced.distance.reshape(height, width),
            thing.reshape(height, width),
            traced.cosine.reshape(height, width),
        )

    def _smoothed(
        self, view: View, T_world_camera: Float64, camera: Camera, pixels: Float64, traced: Traced
    ) -> Float32:
        """Return the radiances (N, 3) with several rays in pixels on edges."""
        width, height = camera.size
        radiance = np.minimum(traced.radiance, BRIGHTEST / self.exposure)
        edge = np.flatnonzero(
            edge_pixels(
                (radiance * np.float32(self.exposure)).reshape(height, width, 3),
                _surfaces(view.lit, traced).reshape(height, width),
                traced.distance.reshape(height, width),
                _slope_per_pixel(traced, camera).reshape(height, width),
            )
        )
        offsets = sub_pixels(self.quality.edge_rays)
        around = (pixels[edge] + offsets[:, None]).reshape(-1, 2)
        more = _trace(view.tracer, T_world_camera, camera, around).radiance
        more = np.minimum(more, BRIGHTEST / self.exposure).reshape(len(offsets), len(edge), 3)
        radiance[edge] = (radiance[edge] + more.sum(axis=0)) / np.float32(1 + len(offsets))
        return radiance

    def _viewed(self, room: LitRoom) -> View:
        shader = Shader(
            corner_tables(room.stage, room.place_light),
            self._textures.surfaces(list(room.stage.materials)),
            lamps(room.room.lights),
        )
        return View(room, Tracer(room.raycaster, shader, self._threads))

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


def _trace(tracer: Tracer, T_world_camera: Float64, camera: Camera, pixels: Float64) -> Traced:
    """Trace through pixel positions (N, 2). A ray's length is such that its distance is z-depth."""
    K = camera.K
    x = ((pixels[:, 0] - K[0, 2]) / K[0, 0]).astype(np.float32)[:, None]
    y = ((pixels[:, 1] - K[1, 2]) / K[1, 1]).astype(np.float32)[:, None]
    right, down, ahead = T_world_camera[:3, :3].T.astype(np.float32)
    origin = T_world_camera[:3, 3].astype(np.float32)
    return tracer.trace(origin, x * right + y * down + ahead, pixel=1 / float(K[0, 0]))


def _surfaces(room: LitRoom, traced: Traced) -> Int32:
    """Number what is seen by thing and material."""
    stage = room.stage
    number = stage.thing_id.astype(np.int32)[traced.face] * np.int32(len(stage.materials))
    surface: Int32 = np.where(traced.face >= 0, number + stage.material[traced.face], -1)
    return surface


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
