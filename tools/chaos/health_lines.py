"""Prints every health message heard at an endpoint, one JSON object a line, until it is ended.

``python -m sceneq_tools.chaos.health_lines tcp/127.0.0.1:7447``
"""

import json
import sys
import threading

from sceneq_nodes._client import Client
from sceneq_schemas.topics import HEALTH

CONNECT_S = 20.0


def main(endpoint: str) -> None:
    """Listen until stdin is closed."""
    lock = threading.Lock()

    def tell(key: str, encoding: str, payload: bytes) -> None:
        with lock:
            print(json.dumps(json.loads(payload)), flush=True)

    with Client(endpoint, CONNECT_S) as client:
        client.subscribe(HEALTH.selector(), tell)
        sys.stdin.read()


if __name__ == "__main__":
    main(sys.argv[1])
