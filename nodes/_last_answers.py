"""The last answers, for whoever comes later: the viewer, or a person who wonders."""

from collections import deque

from sceneq_nodes._answer_json import Json

LAST = 16
LAST_WHOLE = 3
MAX_SHOWN_CHARS = 80


class LastAnswers:
    """Keeps ``LAST`` answers in short and ``LAST_WHOLE`` as they were given."""

    def __init__(self) -> None:
        self._short: deque[Json] = deque(maxlen=LAST)
        self._whole: deque[Json] = deque(maxlen=LAST_WHOLE)

    def keep(self, body: Json) -> None:
        """Remember an answer."""
        best = body["instances"][:1]
        self._whole.append(body)
        self._short.append(
            {
                "query_id": body["query_id"],
                "question": body["question"][:MAX_SHOWN_CHARS],
                "status": body["status"],
                "route": body["route"],
                "best": [{name: match[name] for name in ("id", "label", "p")} for match in best],
                "took_ms": body["took_ms"],
            }
        )

    def newest(self, k: int | None) -> list[Json]:
        """Return all in short, newest first, or the last ``k`` as they were given."""
        kept = self._short if k is None else self._whole
        return list(kept)[::-1][:k]
