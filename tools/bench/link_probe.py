"""Asks questions and counts frames for a while, on whichever machine it runs; prints JSON.

``python -m sceneq_tools.bench.link_probe ENDPOINT SCENE SECONDS``
"""

import json
import sys
import time
from itertools import cycle
from threading import Lock

from sceneq_nodes._client import Client
from sceneq_schemas.topics import FRAME, QUERY_INSTANCES

QUESTIONS = ("chair", "table", "lamp", "sofa", "red mug")
PAUSE_S = 0.05
TIMEOUT_S = 5.0
CONNECT_S = 20.0


class FrameCount:
    """Frames heard, and their bytes."""

    def __init__(self) -> None:
        self.frames = self.bytes = 0
        self._lock = Lock()

    def hear(self, key: str, encoding: str, payload: bytes) -> None:
        """Count one."""
        with self._lock:
            self.frames += 1
            self.bytes += len(payload)


def probe(endpoint: str, scene: str, seconds: float) -> dict[str, object]:
    """Return ``taken_ms`` of answered questions, ``unanswered``, ``frames`` and ``bytes``."""
    heard, taken_ms, unanswered = FrameCount(), [], 0
    key = QUERY_INSTANCES.key(scene=scene)
    with Client(endpoint, CONNECT_S) as client:
        client.subscribe(FRAME.selector(), heard.hear)
        client.get(f"{key}?q={QUESTIONS[0]}", timeout_s=TIMEOUT_S)
        began_s, questions = time.monotonic(), cycle(QUESTIONS)
        heard.frames = heard.bytes = 0
        while time.monotonic() < began_s + seconds:
            start_s = time.perf_counter()
            replies, _ = client.get(f"{key}?q={next(questions)}", timeout_s=TIMEOUT_S)
            if replies:
                taken_ms.append(1000 * (time.perf_counter() - start_s))
            unanswered += not replies
            time.sleep(PAUSE_S)
        lasted_s = time.monotonic() - began_s
    return {
        "seconds": lasted_s,
        "taken_ms": taken_ms,
        "unanswered": unanswered,
        "frames": heard.frames,
        "bytes": heard.bytes,
    }


if __name__ == "__main__":
    print(json.dumps(probe(sys.argv[1], sys.argv[2], float(sys.argv[3]))))
