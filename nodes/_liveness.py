"""Who is there: the liveliness tokens of nodes."""

from typing import Any

from sceneq_schemas.topics import LIVE

TIMEOUT_S = 1.0


def live_nodes(session: Any) -> list[dict[str, str]]:
    """Return the ids in every token that a zenoh session sees, sorted and without repetition."""
    found = session.liveliness().get(LIVE.selector(), timeout=TIMEOUT_S)
    keys = sorted({str(result.ok.key_expr) for result in found if result.ok is not None})
    return [ids for key in keys if (ids := LIVE.ids(key)) is not None]
