"""A recording of a furnished room that does not exist, with everything true about it."""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from sceneq_core.arrays import Float64, Int64, UInt8, UInt16
from sceneq_core.checks import need_at_least, need_positive, need_within
from sceneq_core.ingest.source import Camera
from sceneq_tools.room.layout.changes import changing_room, there_and_back
from sceneq_tools.room.library import Library
from sceneq_tools.room.room import KINDS, Room
from sceneq_tools.room.truth.masks import imperfect_masks
from sceneq_tools.room.truth.questions import questions
from sceneq_tools.room.truth.recording_files import (
    JPEG_QUALITY,
    FrameImages,
    write_camera,
    write_frame,
)
from sceneq_tools.room.truth.sightings import count_pixels, sightings
from sceneq_tools.room.truth.truth import Period, Truth, questions_document

if TYPE_CHECKING:
    from sceneq_tools.room.light.renderer import Renderer
    from sceneq_tools.room.rendering import Rendering

FOCAL_SHARE = 525 / 640
"""Focal length over image width of the Kinect and its successors."""
WORKERS = 2
STREAM_FRAME, STREAM_MASK, STREAM_QUESTIONS, STREAM_CHANGES = range(1, 5)
"""Independent streams of chance, so that one more draw in one leaves the others alone."""

Ticked = Callable[[int], None]


@dataclass(frozen=True, slots=True)
class SynthParams:
    """What to record.

    Attributes:
        seed: of the room, the walk, the noise and the questions.
        kind: of the room, one of ``KINDS``.
        frames: how many; ``rate_hz``: how many a second.
        size: image (width, height), pixels.
        pace: how fast the camera is carried, 1 = a brisk walk.
        changes: how many things change their place on the way, 0 = none.
        clean: without sensor noise.
        questions: at most so many in each of the five buckets.
        jpeg_quality: of the colour images, 1 to 100.
    """

    seed: int = 0
    kind: str = "mixed"
    frames: int = 200
    rate_hz: float = 10.0
    size: tuple[int, int] = (640, 480)
    pace: float = 1.0
    changes: int = 0
    clean: bool = False
    questions: int = 10
    jpeg_quality: int = JPEG_QUALITY

    def __post_init__(self) -> None:
        need_at_least(self, 0, "seed", "changes", "questions")
        need_at_least(self, 1, "frames")
        need_positive(self, "rate_hz", "pace")
        need_within(self, 1, 100, "jpeg_quality")
        if self.kind not in KINDS:
            raise ValueError(f"kind: expected one of {', '.join(KINDS)}, got {self.kind!r}")
        if min(self.size) < 32 or max(self.size) > 4096:
            raise ValueError(f"size: each side must be from 32 to 4096, got {self.size}")
        if self.changes and self.frames < 4:
            raise ValueError(f"frames: a room that changes needs at least 4, got {self.frames}")

    @property
    def camera(self) -> Camera:
        """Colour and depth camera in one."""
        width, height = self.size
        focal = FOCAL_SHARE * width
        K = np.array([[focal, 0, (width - 1) / 2], [0, focal, (height - 1) / 2], [0, 0, 1.0]])
        return Camera(K, self.size)

    def rng(self, *stream: int) -> np.random.Generator:
        """Return the chance of one stream, such as (STREAM_FRAME, number)."""
        return np.random.default_rng((self.seed, *stream))


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Everything about a recording but its pixels."""

    params: SynthParams
    library: Library
    poses: tuple[Float64, ...]
    periods: tuple[Period, ...]

    def frames_of(self, at: int) -> range:
        """Return the numbers of the frames of a period."""
        ends = [period.first for period in self.periods[1:]] + [len(self.poses)]
        return range(self.periods[at].first, ends[at])


def plan(params: SynthParams, library: Library) -> Plan:
    """Furnish the room, walk through it, and decide what changes.

    Raises:
        ValueError: nothing of that kind fits together, or nobody can walk there.
    """
    from sceneq_tools.room.layout.compose import compose

    room = compose(params.kind, params.seed, library)
    if not params.changes:
        return Plan(params, library, tuple(_walk(room, params, params.frames)), (Period(0, room),))
    half = _walk(room, params, -(-params.frames // 2))
    poses = there_and_back(half)[: params.frames]
    rng = params.rng(STREAM_CHANGES)
    periods = changing_room(room, library, poses, params.camera, rng, params.changes)
    return Plan(params, library, tuple(poses), periods)


def record(plan: Plan, renderer: "Renderer", folder: Path, ticked: Ticked) -> Truth:
    """Write every frame, with its masks and its pose, and return what they show.

    ``renderer`` is one of the plan's first room; ``ticked`` is called after every frame.
    """
    rows: list[Int64] = []
    cv2.setNumThreads(1)  # the frames beside each other are threads enough
    with ThreadPoolExecutor(WORKERS) as pool:
        for at, period in enumerate(plan.periods):
            if at:
                renderer.update(period.room)
            numbers = plan.frames_of(at)
            try:
                for counted in pool.map(lambda n: _write(plan, renderer, folder, n), numbers):
                    rows.append(counted)
                    ticked(1)
            except BaseException:
                pool.shutdown(cancel_futures=True)
                raise
    width, height = plan.params.size
    return Truth(plan.periods, sightings(rows, plan.params.rate_hz, width * height))


def write_truth(plan: Plan, truth: Truth, folder: Path, command: str) -> dict[str, Any]:
    """Write the camera, instances, questions, attribution and README; return the questions."""
    params = plan.params
    write_camera(folder, params.camera.K, np.arange(params.frames) / params.rate_hz)
    asked = questions(truth.survey(), params.rng(STREAM_QUESTIONS), params.questions)
    queries = questions_document(
        f"{params.kind}_{params.seed}", asked, truth.names(), params.frames
    )
    _write_json(folder / "instances.json", truth.instances(plan.library.attribution))
    _write_json(folder / "queries.json", queries)
    (folder / "ATTRIBUTION.txt").write_text("\n".join(_attribution(plan)) + "\n")
    (folder / "README.md").write_text(_readme(plan, truth, queries, command))
    return queries


def _walk(room: Room, params: SynthParams, frames: int) -> list[Float64]:
    from sceneq_tools.room.camera.camera_path import camera_path
    from sceneq_tools.room.camera.pace import Pace

    brisk = Pace()
    pace = replace(
        brisk,
        walk_m_s=brisk.walk_m_s * params.pace,
        turn_deg_s=brisk.turn_deg_s * params.pace,
    )
    return camera_path(room, frames, params.rate_hz, params.seed, pace, params.camera)


def _write(plan: Plan, renderer: "Renderer", folder: Path, number: int) -> Int64:
    rendering = renderer.render(plan.poses[number], plan.params.camera)
    rgb, depth_mm = _measured(plan.params, rendering, number)
    mask = imperfect_masks(rendering.instance_id, plan.params.rng(STREAM_MASK, number))
    images = FrameImages(rgb, depth_mm, rendering.instance_id, mask)
    write_frame(folder, number, images, plan.poses[number], plan.params.jpeg_quality)
    return count_pixels(rendering.instance_id)


def _measured(params: SynthParams, rendering: "Rendering", number: int) -> tuple[UInt8, UInt16]:
    if params.clean:
        return rendering.rgb, np.round(rendering.depth_m * 1000).astype(np.uint16)
    from sceneq_tools.room.camera.sensor import measure

    return measure(rendering, params.rng(STREAM_FRAME, number))


def _write_json(path: Path, document: dict[str, Any]) -> None:
    """One line a record: small, and a difference between two files can be read."""
    parts = []
    for key, value in document.items():
        if isinstance(value, list):
            rows = ",\n".join(f"  {json.dumps(row, ensure_ascii=False)}" for row in value)
            parts.append(f' "{key}": [\n{rows}\n ]')
        else:
            parts.append(f' "{key}": {json.dumps(value, ensure_ascii=False)}')
    path.write_text("{\n" + ",\n".join(parts) + "\n}\n")


def _attribution(plan: Plan) -> Iterator[str]:
    """Yield one line for every model whose licence asks for it, and what was done to it."""
    made_of = f"3D models of {plan.library.name}: rendered, rescaled, some recoloured."
    yield f"The pictures show {made_of}"
    models = {thing.model_id for p in plan.periods for thing in p.room.things if thing.model_id}
    for model_id in sorted(models):
        if line := plan.library.attribution(model_id):
            yield f"{model_id}: {line}"


def _readme(plan: Plan, truth: Truth, queries: dict[str, Any], command: str) -> str:
    from sceneq_tools.room.truth.recording_files import SIGNATURE

    params = plan.params
    width, height = params.size
    solid = [thing for thing in truth.things() if not thing.is_stuff]
    changes = [change for period in plan.periods for change in period.changes]
    lines = [
        f"# A room that does not exist: {params.kind.replace('_', ' ')}, seed {params.seed}",
        "",
        f"{SIGNATURE}; the exact command:",
        "",
        f"    {command}",
        "",
        f"{params.frames} frames of {width}x{height} at {params.rate_hz:g} Hz of a room with "
        f"{len(solid)} things under {len({t.label for t in solid})} names"
        f"{', without sensor noise' if params.clean else ''}. "
        f"{len(queries['queries'])} questions with their answers.",
        "",
        "| file | what |",
        "|---|---|",
        "| `frame-*.color.jpg`, `.depth.png`, `.pose.txt` | RGB; uint16 mm, 0 = no measurement, "
        "registered; 4x4 T_world_camera, metres, z up in the world |",
        "| `frame-*.instance.png` | exact ids, uint16, 0 = nothing |",
        "| `frame-*.mask.png` | segments as a 2D model might find them: missed, split, merged, "
        "drawn in; numbers unrelated between frames |",
        "| `instances.json` | ids, names, boxes from a frame on (null = not there), attributes, "
        'support; relations; edits: [dx, dy, dz, turn in degrees], null = gone, "new" |',
        "| `queries.json` | questions in five buckets, asked after the last frame |",
        "| `ATTRIBUTION.txt` | authors and licences of the models |",
        "",
        *(f"From frame {plan.periods[-1].first}: {change}." for change in changes),
    ]
    return "\n".join(lines).rstrip() + "\n"
