"""A picture as the question: decoded, encoded by the image tower, compared with the instances.

The image tower is loaded by the first picture, on that query's own thread; no other query waits.
"""

from collections.abc import Callable
from dataclasses import replace
from threading import Lock

import numpy as np

from sceneq_core.arrays import Float32, UInt8
from sceneq_core.routing.forms import PICTURE
from sceneq_core.routing.matches import MAX_MATCHES
from sceneq_core.routing.phrase import Phrase
from sceneq_core.routing.question import Question
from sceneq_core.routing.report import Report
from sceneq_core.routing.router import Router
from sceneq_core.routing.whereabouts import whereabouts
from sceneq_nodes._answer_json import Json
from sceneq_nodes._ask import DEFAULT_K, Ask
from sceneq_nodes._bus import QueryError
from sceneq_nodes._image_file import decode_rgb, header
from sceneq_nodes._look import Look
from sceneq_nodes._report_json import report_json
from sceneq_nodes._stopwatch import Stopwatch

MAX_PIXELS = 4_000_000
MIN_SIDE_PX = 8

Seeing = Callable[[UInt8], Float32]
"""Picture uint8 (H, W, 3) RGB -> descriptor (D,); ``NotImplementedError`` without a tower."""


def blind(rgb: UInt8) -> Float32:
    """Say that there is no image tower here."""
    raise NotImplementedError("no image tower")


class PictureQuestions:
    """Answers what looks like a picture; one picture is encoded at a time."""

    def __init__(self, scene: str, router: Router, seeing: Seeing = blind) -> None:
        self._scene = scene
        self._router = router
        self._seeing = seeing
        self._busy = Lock()

    def answer(self, ask: Ask, look: Look, watch: Stopwatch) -> Json:
        """Return the body of the answer.

        Raises:
            QueryError: ``bad_request``, no picture that can be used; ``unavailable``, no tower.
        """
        rgb = _decoded(ask.picture)
        descriptor = self._see(rgb)
        watch.lap("image")
        answer = self._router.pictures.answer(look.snapshot, descriptor)
        watch.lap("search")
        best = answer.matches[0] if answer.matches else None
        height, width = rgb.shape[:2]
        report = Report(
            kind=PICTURE,
            question=Question("picture", Phrase("", ()), {}),
            answer=replace(answer, question=f"picture of {width} x {height} pixels"),
            where=whereabouts(look.snapshot, best.instance) if best else None,
        )
        k = min(ask.k or DEFAULT_K, MAX_MATCHES)
        return report_json(report, k, look.stamp(self._scene, watch))

    def _see(self, rgb: UInt8) -> Float32:
        try:
            with self._busy:
                descriptor = self._seeing(rgb)
        except NotImplementedError as error:
            hint = "ask in words"
            raise QueryError("unavailable", "this encoder sees no pictures", hint) from error
        if not np.isfinite(descriptor).all():
            raise QueryError("bad_request", "the encoder makes nothing of this picture")
        return descriptor


def _decoded(data: bytes) -> UInt8:
    try:
        width, height = header(data).size
        if not min(width, height) >= MIN_SIDE_PX or width * height > MAX_PIXELS:
            limits = f"sides from {MIN_SIDE_PX} pixels, at most {MAX_PIXELS} in all"
            raise ValueError(f"{width} x {height} pixels, expected {limits}")
        return decode_rgb(data)
    except ValueError as error:
        raise QueryError("bad_request", f"picture: {error}", "send a JPEG or PNG crop") from error
