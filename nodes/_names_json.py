"""Taught names as clients see them."""

from collections.abc import Mapping

from sceneq_core.routing.names import GivenName
from sceneq_core.routing.scene import SceneSnapshot
from sceneq_core.teaching.taught import Taught, when
from sceneq_core.teaching.wording import CATEGORY
from sceneq_nodes._answer_json import Json
from sceneq_nodes._name_keeper import NameKeeper

ATTACHED, UNATTACHED = "attached", "unattached"
P_DIGITS = 4


def name_json(one: Taught, keeper: NameKeeper, snapshot: SceneSnapshot) -> Json:
    """Return a name, the instance it is of now and who inherits it."""
    held = keeper.held(one)
    given = _given(one, snapshot)
    row = snapshot.find(held.instance_id) if held else None
    p = given.p.get(row, 0.0) if given and row is not None else 0.0
    return {
        "name": one.name,
        "kind": one.kind,
        "by": one.by,
        "stamp_ns": one.stamp_ns,
        "when": when(one.stamp_ns),
        "state": ATTACHED if held else UNATTACHED,
        "id": held.instance_id if held else None,
        "p": round(p, P_DIGITS),
        "centre": one.spot.centre_world.round(3).tolist(),
        "inherited": _inherited(given, keeper, snapshot) if one.kind == CATEGORY else [],
        "maybe": _heirs(given.maybe, snapshot) if given else [],
    }


def _given(one: Taught, snapshot: SceneSnapshot) -> GivenName | None:
    named = (given for names in snapshot.names.given.values() for given in names)
    return next((given for given in named if given.name == one.name), None)


def _inherited(given: GivenName | None, keeper: NameKeeper, snapshot: SceneSnapshot) -> list[Json]:
    """Return the look-alikes of all that were taught this name, the surest first."""
    same = keeper.find(given.name) if given else ()
    taught = {at.instance_id for other in same if (at := keeper.held(other))}
    heirs = _heirs(given.p if given else {}, snapshot)
    return [heir for heir in heirs if heir["id"] not in taught]


def _heirs(p: Mapping[int, float], snapshot: SceneSnapshot) -> list[Json]:
    found = sorted((-p[row], snapshot.instances[row].instance_id) for row in p)
    return [{"id": key, "p": round(-minus_p, P_DIGITS)} for minus_p, key in found]
